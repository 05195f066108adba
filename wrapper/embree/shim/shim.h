/*
 * One face for Embree 3.13 and 4.x. CURVETRI_EMBREE is 3 or 4, set by build.rs from the headers it
 * found. The Rust side is generated from this file (src/embree/bindings_3.rs, bindings_4.rs).
 */
#ifndef CURVETRI_SHIM_H
#define CURVETRI_SHIM_H

#if CURVETRI_EMBREE == 4
#include <embree4/rtcore.h>
#elif CURVETRI_EMBREE == 3
#include <embree3/rtcore.h>
#else
#error "CURVETRI_EMBREE must be 3 or 4"
#endif

/*
 * Every Embree function that curvetri calls. Our own programs fill it from the library they link
 * (linked.c, the one place that names those functions); a host application that brings its own
 * Embree fills it from that one, so that both sides use the same library.
 */
struct CurvetriEmbree
{
  RTCDevice (*new_device)(const char *config);
  void (*release_device)(RTCDevice device);
  ssize_t (*get_device_property)(RTCDevice device, enum RTCDeviceProperty property);
  enum RTCError (*get_device_error)(RTCDevice device);
  void (*set_device_error_function)(RTCDevice device, RTCErrorFunction function, void *user);
  void (*set_device_memory_monitor)(RTCDevice device, RTCMemoryMonitorFunction function, void *user);

  RTCGeometry (*new_geometry)(RTCDevice device, enum RTCGeometryType type);
  void (*release_geometry)(RTCGeometry geometry);
  void (*commit_geometry)(RTCGeometry geometry);
  void (*set_geometry_user_data)(RTCGeometry geometry, void *user);
  void (*set_geometry_mask)(RTCGeometry geometry, unsigned int mask);
  void (*set_geometry_build_quality)(RTCGeometry geometry, enum RTCBuildQuality quality);
  void (*set_geometry_time_step_count)(RTCGeometry geometry, unsigned int count);
  void (*set_geometry_tessellation_rate)(RTCGeometry geometry, float rate);
  void *(*set_new_geometry_buffer)(RTCGeometry geometry, enum RTCBufferType type, unsigned int slot,
                                   enum RTCFormat format, size_t stride, size_t count);
  void (*set_geometry_intersect_filter)(RTCGeometry geometry, RTCFilterFunctionN filter);
  void (*set_geometry_occluded_filter)(RTCGeometry geometry, RTCFilterFunctionN filter);
  void (*set_geometry_primitive_count)(RTCGeometry geometry, unsigned int count);
  void (*set_geometry_bounds_function)(RTCGeometry geometry, RTCBoundsFunction function, void *user);
  void (*set_geometry_intersect_function)(RTCGeometry geometry, RTCIntersectFunctionN function);
  void (*set_geometry_occluded_function)(RTCGeometry geometry, RTCOccludedFunctionN function);
  void (*set_geometry_instanced_scene)(RTCGeometry geometry, RTCScene scene);
  void (*set_geometry_transform)(RTCGeometry geometry, unsigned int time_step, enum RTCFormat format,
                                 const void *matrix);

  RTCScene (*new_scene)(RTCDevice device);
  void (*release_scene)(RTCScene scene);
  void (*set_scene_flags)(RTCScene scene, enum RTCSceneFlags flags);
  void (*set_scene_build_quality)(RTCScene scene, enum RTCBuildQuality quality);
  unsigned int (*attach_geometry)(RTCScene scene, RTCGeometry geometry);
  void (*commit_scene)(RTCScene scene);
  void (*get_scene_bounds)(RTCScene scene, struct RTCBounds *bounds);

#if CURVETRI_EMBREE == 4
#define CURVETRI_INTERSECT , struct RTCIntersectArguments *arguments
#define CURVETRI_OCCLUDED , struct RTCOccludedArguments *arguments
#define CURVETRI_CONTEXT
#else
#define CURVETRI_INTERSECT
#define CURVETRI_OCCLUDED
#define CURVETRI_CONTEXT struct RTCIntersectContext *context,
#endif
  void (*intersect1)(RTCScene scene, CURVETRI_CONTEXT struct RTCRayHit *rayhit CURVETRI_INTERSECT);
  void (*intersect4)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRayHit4 *rayhit CURVETRI_INTERSECT);
  void (*intersect8)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRayHit8 *rayhit CURVETRI_INTERSECT);
  void (*intersect16)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRayHit16 *rayhit CURVETRI_INTERSECT);
  void (*occluded1)(RTCScene scene, CURVETRI_CONTEXT struct RTCRay *ray CURVETRI_OCCLUDED);
  void (*occluded4)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRay4 *ray CURVETRI_OCCLUDED);
  void (*occluded8)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRay8 *ray CURVETRI_OCCLUDED);
  void (*occluded16)(const int *valid, RTCScene scene, CURVETRI_CONTEXT struct RTCRay16 *ray CURVETRI_OCCLUDED);

  /* 3.13: run the geometry's and the context's filter; 4.x: run the geometry's only */
  void (*filter_intersect)(const struct RTCIntersectFunctionNArguments *call,
                           const struct RTCFilterFunctionNArguments *candidate);
  void (*filter_occluded)(const struct RTCOccludedFunctionNArguments *call,
                          const struct RTCFilterFunctionNArguments *candidate);
};

/* The functions in use. */
const struct CurvetriEmbree *curvetri_embree(void);

/* The functions of the library this program is linked with (linked.c). */
extern const struct CurvetriEmbree curvetri_linked_embree;

/* RTC_VERSION of the headers the shim was compiled with. */
unsigned int curvetri_headers_version(void);

/* The scene flag without which a query's own filter must not be used. */
unsigned int curvetri_query_filter_scene_flag(void);

/* What a query asks for beside its rays. */
struct CurvetriQuery
{
  unsigned int coherent;     /* 1: the packet's rays are alike */
  RTCFilterFunctionN filter; /* the query's own filter, or NULL; needs the scene flag */
};

/*
 * Traces a packet of width 1, 4, 8 or 16: an RTCRayHit or RTCRay of that width. `valid` and the packet
 * are aligned to width * 4 bytes (16 at least); `valid` is not read for width 1. The width is one that
 * the processor has: for others 3.13 does not look at `valid`, and rtcOccluded of 4.3 writes the hits
 * of an RTCRayHit behind the RTCRay.
 */
void curvetri_intersect(unsigned int width, const int *valid, RTCScene scene, void *rayhit,
                        const struct CurvetriQuery *query);
void curvetri_occluded(unsigned int width, const int *valid, RTCScene scene, void *rayhit,
                       const struct CurvetriQuery *query);

/*
 * From a user geometry's callback: runs the geometry's filter and then the query's on a candidate.
 * `call` is Embree's own struct, never a copy: there are private fields behind it. `query_filter` is
 * the filter of the query under way, or NULL.
 */
void curvetri_filter_intersect(const struct RTCIntersectFunctionNArguments *call,
                               const struct RTCFilterFunctionNArguments *candidate,
                               RTCFilterFunctionN query_filter);
void curvetri_filter_occluded(const struct RTCOccludedFunctionNArguments *call,
                              const struct RTCFilterFunctionNArguments *candidate,
                              RTCFilterFunctionN query_filter);

#endif

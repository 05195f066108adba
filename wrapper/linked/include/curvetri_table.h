/*
 * The Embree that curvetri uses, as a table of functions and facts. The table is the same for Embree 3.13 and 4.x, so
 * that one binary of curvetri serves both. curvetri_embree.h fills it.
 *
 * C99 or C++11; no header of Embree is needed. The Rust side is generated from this file: after a change, count
 * CURVETRI_TABLE_VERSION up and run `ci/bindings.sh --write`.
 */
#ifndef CURVETRI_TABLE_H
#define CURVETRI_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CURVETRI_TABLE_VERSION 1

/* Embree's own handles: RTCDevice, RTCGeometry, RTCScene. */
struct CurvetriDevice;
struct CurvetriGeometry;
struct CurvetriScene;

/* RTCBounds */
struct CurvetriBounds
{
  float lower_x, lower_y, lower_z, align0;
  float upper_x, upper_y, upper_z, align1;
};

/* RTCBoundsFunctionArguments */
struct CurvetriBoundsCall
{
  void *user;
  unsigned int prim_id;
  unsigned int time_step;
  struct CurvetriBounds *bounds;
};

/* RTCIntersectFunctionNArguments and RTCOccludedFunctionNArguments. Embree keeps fields of its own behind it, so a
 * copy of it must never be passed back to Embree. */
struct CurvetriCall
{
  int *valid;
  void *user;
  unsigned int prim_id;
  void *context;
  void *rays; /* RTCRayHitN or RTCRayN */
  unsigned int width;
  unsigned int geom_id;
};

/* RTCFilterFunctionNArguments */
struct CurvetriCandidate
{
  int *valid;
  void *user;
  const void *context;
  void *ray; /* RTCRayN */
  void *hit; /* RTCHitN */
  unsigned int width;
};

typedef void (*CurvetriErrorFunction)(void *user, unsigned int code, const char *message);
typedef bool (*CurvetriMemoryFunction)(void *user, ptrdiff_t bytes, bool post);
typedef void (*CurvetriBoundsFunction)(const struct CurvetriBoundsCall *call);
typedef void (*CurvetriCallFunction)(const struct CurvetriCall *call);
typedef void (*CurvetriFilterFunction)(const struct CurvetriCandidate *candidate);

/* What a query asks for beside its rays. */
struct CurvetriQuery
{
  unsigned int coherent;         /* 1: the packet's rays are alike */
  CurvetriFilterFunction filter; /* the query's own filter, or NULL; it needs query_filter_scene_flag */
};

struct CurvetriEmbree
{
  /* These are compared before anything else is used. */
  unsigned int table_version;   /* CURVETRI_TABLE_VERSION */
  unsigned int table_size;      /* sizeof(struct CurvetriEmbree) */
  unsigned int headers_version; /* RTC_VERSION of Embree's headers, as in 31305 */
  unsigned int instance_levels; /* RTC_MAX_INSTANCE_LEVEL_COUNT */
  unsigned int inst_prim_id;    /* 1: hits and contexts have instPrimID behind instID */
  unsigned int rayhit_size[4];  /* sizeof(struct RTCRayHit), ...4, ...8, ...16 */

  unsigned int context_inst_id;         /* where instID is in a query's context, in bytes */
  unsigned int query_filter_scene_flag; /* the scene flag without which a query must not bring a filter */

  /* Embree's functions of these names, with its enumerations as numbers. */
  struct CurvetriDevice *(*new_device)(const char *config);
  void (*release_device)(struct CurvetriDevice *device);
  ptrdiff_t (*get_device_property)(struct CurvetriDevice *device, unsigned int property);
  unsigned int (*get_device_error)(struct CurvetriDevice *device);
  void (*set_device_error_function)(struct CurvetriDevice *device, CurvetriErrorFunction function, void *user);
  void (*set_device_memory_monitor)(struct CurvetriDevice *device, CurvetriMemoryFunction function, void *user);

  struct CurvetriGeometry *(*new_geometry)(struct CurvetriDevice *device, unsigned int type);
  void (*release_geometry)(struct CurvetriGeometry *geometry);
  void (*commit_geometry)(struct CurvetriGeometry *geometry);
  void (*set_geometry_user_data)(struct CurvetriGeometry *geometry, void *user);
  void (*set_geometry_mask)(struct CurvetriGeometry *geometry, unsigned int mask);
  void (*set_geometry_build_quality)(struct CurvetriGeometry *geometry, unsigned int quality);
  void (*set_geometry_time_step_count)(struct CurvetriGeometry *geometry, unsigned int count);
  void (*set_geometry_tessellation_rate)(struct CurvetriGeometry *geometry, float rate);
  void *(*set_new_geometry_buffer)(struct CurvetriGeometry *geometry, unsigned int type, unsigned int slot,
                                   unsigned int format, size_t stride, size_t count);
  void (*set_geometry_intersect_filter)(struct CurvetriGeometry *geometry, CurvetriFilterFunction filter);
  void (*set_geometry_occluded_filter)(struct CurvetriGeometry *geometry, CurvetriFilterFunction filter);
  void (*set_geometry_primitive_count)(struct CurvetriGeometry *geometry, unsigned int count);
  void (*set_geometry_bounds_function)(struct CurvetriGeometry *geometry, CurvetriBoundsFunction function);
  void (*set_geometry_intersect_function)(struct CurvetriGeometry *geometry, CurvetriCallFunction function);
  void (*set_geometry_occluded_function)(struct CurvetriGeometry *geometry, CurvetriCallFunction function);
  void (*set_geometry_instanced_scene)(struct CurvetriGeometry *geometry, struct CurvetriScene *scene);
  void (*set_geometry_transform)(struct CurvetriGeometry *geometry, unsigned int time_step, unsigned int format,
                                 const void *matrix);

  struct CurvetriScene *(*new_scene)(struct CurvetriDevice *device);
  void (*release_scene)(struct CurvetriScene *scene);
  void (*set_scene_flags)(struct CurvetriScene *scene, unsigned int flags);
  void (*set_scene_build_quality)(struct CurvetriScene *scene, unsigned int quality);
  unsigned int (*attach_geometry)(struct CurvetriScene *scene, struct CurvetriGeometry *geometry);
  void (*commit_scene)(struct CurvetriScene *scene);
  void (*get_scene_bounds)(struct CurvetriScene *scene, struct CurvetriBounds *bounds);

  /*
   * Traces a packet of width 1, 4, 8 or 16: an RTCRayHit or RTCRay of that width. `valid` and the packet are aligned
   * to width * 4 bytes (16 at least); `valid` is not read for width 1. The width is one that the processor has: for
   * others 3.13 does not look at `valid`, and rtcOccluded of 4.3 writes the hits of an RTCRayHit behind the RTCRay.
   */
  void (*intersect)(unsigned int width, const int *valid, struct CurvetriScene *scene, void *rayhit,
                    const struct CurvetriQuery *query);
  void (*occluded)(unsigned int width, const int *valid, struct CurvetriScene *scene, void *ray,
                   const struct CurvetriQuery *query);

  /*
   * From a user geometry's callback: runs the geometry's filter and then the query's on a candidate. `call` is the
   * pointer that Embree passed. `query_filter` is the filter that the query under way has in its CurvetriQuery, or NULL.
   */
  void (*filter_intersect)(const struct CurvetriCall *call, const struct CurvetriCandidate *candidate,
                           CurvetriFilterFunction query_filter);
  void (*filter_occluded)(const struct CurvetriCall *call, const struct CurvetriCandidate *candidate,
                          CurvetriFilterFunction query_filter);
};

#ifdef __cplusplus
}
#endif

#endif

/*
 * Fills curvetri's table (curvetri_table.h) with the Embree whose rtcore.h, 3.13 or 4.3 and later, was included before
 * this file. All of it is static, so it belongs to the translation unit that includes it. C11 or C++11.
 */
#ifndef CURVETRI_EMBREE_H
#define CURVETRI_EMBREE_H

#include "curvetri_table.h"

#ifndef RTC_VERSION
#error "include Embree's rtcore.h before curvetri_embree.h"
#endif
#if RTC_VERSION < 31300 || (RTC_VERSION >= 40000 && RTC_VERSION < 40300)
#error "curvetri needs Embree 3.13 or 4.3 and later"
#endif

#ifdef __cplusplus
#define CURVETRI_ASSERT(condition, message) static_assert(condition, message)
#define CURVETRI_ALIGNOF(type) alignof(type)
#else
#define CURVETRI_ASSERT(condition, message) _Static_assert(condition, message)
#define CURVETRI_ALIGNOF(type) _Alignof(type)
#endif

/*
 * The layouts that curvetri relies on. A packet is arrays of `width` four-byte fields: twelve of the ray, then the
 * hit's seven, then instance ids by level.
 */
#define CURVETRI_FIELD(type, field, index, width) \
  CURVETRI_ASSERT(offsetof(type, field) == 4 * (index) * (width), #type "." #field)

#define CURVETRI_RAY_LAYOUT(type, width, alignment)                         \
  CURVETRI_FIELD(type, org_x, 0, width);                                    \
  CURVETRI_FIELD(type, tnear, 3, width);                                    \
  CURVETRI_FIELD(type, dir_x, 4, width);                                    \
  CURVETRI_FIELD(type, time, 7, width);                                     \
  CURVETRI_FIELD(type, tfar, 8, width);                                     \
  CURVETRI_FIELD(type, mask, 9, width);                                     \
  CURVETRI_FIELD(type, id, 10, width);                                      \
  CURVETRI_FIELD(type, flags, 11, width);                                   \
  CURVETRI_ASSERT(sizeof(type) == 48 * (width), "size of " #type);          \
  CURVETRI_ASSERT(CURVETRI_ALIGNOF(type) == (alignment), "alignment of " #type)

#define CURVETRI_LEVELS RTC_MAX_INSTANCE_LEVEL_COUNT
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
#define CURVETRI_HIT_FIELDS (7 + 2 * CURVETRI_LEVELS)
#define CURVETRI_INSTANCE_LAYOUT(type, width)  \
  CURVETRI_FIELD(type, instID, 7, width);      \
  CURVETRI_FIELD(type, instPrimID, 7 + CURVETRI_LEVELS, width)
#else
#define CURVETRI_HIT_FIELDS (7 + CURVETRI_LEVELS)
#define CURVETRI_INSTANCE_LAYOUT(type, width) CURVETRI_FIELD(type, instID, 7, width)
#endif

/* rounded up to the alignment */
#define CURVETRI_PADDED(size, alignment) (((size) + (alignment)-1) / (alignment) * (alignment))

#define CURVETRI_HIT_LAYOUT(type, width, alignment)                                                   \
  CURVETRI_FIELD(type, Ng_x, 0, width);                                                               \
  CURVETRI_FIELD(type, u, 3, width);                                                                  \
  CURVETRI_FIELD(type, v, 4, width);                                                                  \
  CURVETRI_FIELD(type, primID, 5, width);                                                             \
  CURVETRI_FIELD(type, geomID, 6, width);                                                             \
  CURVETRI_INSTANCE_LAYOUT(type, width);                                                              \
  CURVETRI_ASSERT(sizeof(type) == CURVETRI_PADDED(4 * CURVETRI_HIT_FIELDS * (width), alignment),      \
                  "size of " #type);                                                                  \
  CURVETRI_ASSERT(CURVETRI_ALIGNOF(type) == (alignment), "alignment of " #type)

#define CURVETRI_PACKET_LAYOUT(suffix, width, alignment)                                  \
  CURVETRI_RAY_LAYOUT(struct RTCRay##suffix, width, alignment);                           \
  CURVETRI_HIT_LAYOUT(struct RTCHit##suffix, width, alignment);                           \
  CURVETRI_FIELD(struct RTCRayHit##suffix, ray, 0, width);                                \
  CURVETRI_FIELD(struct RTCRayHit##suffix, hit, 12, width);                               \
  CURVETRI_ASSERT(sizeof(struct RTCRayHit##suffix) ==                                     \
                      sizeof(struct RTCRay##suffix) + sizeof(struct RTCHit##suffix),      \
                  "size of RTCRayHit" #suffix)

CURVETRI_PACKET_LAYOUT(, 1, 16);
CURVETRI_PACKET_LAYOUT(4, 4, 16);
CURVETRI_PACKET_LAYOUT(8, 8, 32);
CURVETRI_PACKET_LAYOUT(16, 16, 64);

/* The table's structs and Embree's have their fields at the same places. */
#define CURVETRI_SAME(type, field, embree_type, embree_field)                                 \
  CURVETRI_ASSERT(offsetof(struct type, field) == offsetof(struct embree_type, embree_field), \
                  #embree_type "." #embree_field)
#define CURVETRI_SAME_SIZE(type, embree_type) \
  CURVETRI_ASSERT(sizeof(struct type) == sizeof(struct embree_type), "size of " #embree_type)

CURVETRI_ASSERT(sizeof(void *) == 8, "curvetri needs a 64-bit system");
CURVETRI_SAME(CurvetriBounds, lower_x, RTCBounds, lower_x);
CURVETRI_SAME(CurvetriBounds, upper_x, RTCBounds, upper_x);
CURVETRI_SAME_SIZE(CurvetriBounds, RTCBounds);

CURVETRI_SAME(CurvetriBoundsCall, user, RTCBoundsFunctionArguments, geometryUserPtr);
CURVETRI_SAME(CurvetriBoundsCall, prim_id, RTCBoundsFunctionArguments, primID);
CURVETRI_SAME(CurvetriBoundsCall, time_step, RTCBoundsFunctionArguments, timeStep);
CURVETRI_SAME(CurvetriBoundsCall, bounds, RTCBoundsFunctionArguments, bounds_o);
CURVETRI_SAME_SIZE(CurvetriBoundsCall, RTCBoundsFunctionArguments);

#define CURVETRI_CALL_LAYOUT(embree_type, embree_rays)            \
  CURVETRI_SAME(CurvetriCall, valid, embree_type, valid);         \
  CURVETRI_SAME(CurvetriCall, user, embree_type, geometryUserPtr); \
  CURVETRI_SAME(CurvetriCall, prim_id, embree_type, primID);      \
  CURVETRI_SAME(CurvetriCall, context, embree_type, context);     \
  CURVETRI_SAME(CurvetriCall, rays, embree_type, embree_rays);    \
  CURVETRI_SAME(CurvetriCall, width, embree_type, N);             \
  CURVETRI_SAME(CurvetriCall, geom_id, embree_type, geomID);      \
  CURVETRI_SAME_SIZE(CurvetriCall, embree_type)
CURVETRI_CALL_LAYOUT(RTCIntersectFunctionNArguments, rayhit);
CURVETRI_CALL_LAYOUT(RTCOccludedFunctionNArguments, ray);

CURVETRI_SAME(CurvetriCandidate, valid, RTCFilterFunctionNArguments, valid);
CURVETRI_SAME(CurvetriCandidate, user, RTCFilterFunctionNArguments, geometryUserPtr);
CURVETRI_SAME(CurvetriCandidate, context, RTCFilterFunctionNArguments, context);
CURVETRI_SAME(CurvetriCandidate, ray, RTCFilterFunctionNArguments, ray);
CURVETRI_SAME(CurvetriCandidate, hit, RTCFilterFunctionNArguments, hit);
CURVETRI_SAME(CurvetriCandidate, width, RTCFilterFunctionNArguments, N);
CURVETRI_SAME_SIZE(CurvetriCandidate, RTCFilterFunctionNArguments);

/* What differs between the two generations in a query's context. */
#if RTC_VERSION >= 40000
#define CURVETRI_CONTEXT struct RTCRayQueryContext
#else
#define CURVETRI_CONTEXT struct RTCIntersectContext
#endif
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
CURVETRI_ASSERT(offsetof(CURVETRI_CONTEXT, instPrimID) ==
                    offsetof(CURVETRI_CONTEXT, instID) + 4 * CURVETRI_LEVELS,
                "instPrimID of a query's context");
#endif

#ifdef __cplusplus
extern "C" {
#endif

static struct CurvetriDevice *curvetri_rtc_new_device(const char *config)
{
  return (struct CurvetriDevice *)rtcNewDevice(config);
}

static void curvetri_rtc_release_device(struct CurvetriDevice *device) { rtcReleaseDevice((RTCDevice)device); }

static ptrdiff_t curvetri_rtc_get_device_property(struct CurvetriDevice *device, unsigned int property)
{
  return rtcGetDeviceProperty((RTCDevice)device, (enum RTCDeviceProperty)property);
}

static unsigned int curvetri_rtc_get_device_error(struct CurvetriDevice *device)
{
  return (unsigned int)rtcGetDeviceError((RTCDevice)device);
}

static void curvetri_rtc_set_device_error_function(struct CurvetriDevice *device, CurvetriErrorFunction function,
                                                   void *user)
{
  rtcSetDeviceErrorFunction((RTCDevice)device, (RTCErrorFunction)function, user);
}

static void curvetri_rtc_set_device_memory_monitor(struct CurvetriDevice *device, CurvetriMemoryFunction function,
                                                   void *user)
{
  rtcSetDeviceMemoryMonitorFunction((RTCDevice)device, (RTCMemoryMonitorFunction)function, user);
}

static struct CurvetriGeometry *curvetri_rtc_new_geometry(struct CurvetriDevice *device, unsigned int type)
{
  return (struct CurvetriGeometry *)rtcNewGeometry((RTCDevice)device, (enum RTCGeometryType)type);
}

static void curvetri_rtc_release_geometry(struct CurvetriGeometry *geometry)
{
  rtcReleaseGeometry((RTCGeometry)geometry);
}

static void curvetri_rtc_commit_geometry(struct CurvetriGeometry *geometry)
{
  rtcCommitGeometry((RTCGeometry)geometry);
}

static void curvetri_rtc_set_geometry_user_data(struct CurvetriGeometry *geometry, void *user)
{
  rtcSetGeometryUserData((RTCGeometry)geometry, user);
}

static void curvetri_rtc_set_geometry_mask(struct CurvetriGeometry *geometry, unsigned int mask)
{
  rtcSetGeometryMask((RTCGeometry)geometry, mask);
}

static void curvetri_rtc_set_geometry_build_quality(struct CurvetriGeometry *geometry, unsigned int quality)
{
  rtcSetGeometryBuildQuality((RTCGeometry)geometry, (enum RTCBuildQuality)quality);
}

static void curvetri_rtc_set_geometry_time_step_count(struct CurvetriGeometry *geometry, unsigned int count)
{
  rtcSetGeometryTimeStepCount((RTCGeometry)geometry, count);
}

static void curvetri_rtc_set_geometry_tessellation_rate(struct CurvetriGeometry *geometry, float rate)
{
  rtcSetGeometryTessellationRate((RTCGeometry)geometry, rate);
}

static void *curvetri_rtc_set_new_geometry_buffer(struct CurvetriGeometry *geometry, unsigned int type,
                                                  unsigned int slot, unsigned int format, size_t stride,
                                                  size_t count)
{
  return rtcSetNewGeometryBuffer((RTCGeometry)geometry, (enum RTCBufferType)type, slot, (enum RTCFormat)format,
                                 stride, count);
}

static void curvetri_rtc_set_geometry_intersect_filter(struct CurvetriGeometry *geometry,
                                                       CurvetriFilterFunction filter)
{
  rtcSetGeometryIntersectFilterFunction((RTCGeometry)geometry, (RTCFilterFunctionN)filter);
}

static void curvetri_rtc_set_geometry_occluded_filter(struct CurvetriGeometry *geometry,
                                                      CurvetriFilterFunction filter)
{
  rtcSetGeometryOccludedFilterFunction((RTCGeometry)geometry, (RTCFilterFunctionN)filter);
}

static void curvetri_rtc_set_geometry_primitive_count(struct CurvetriGeometry *geometry, unsigned int count)
{
  rtcSetGeometryUserPrimitiveCount((RTCGeometry)geometry, count);
}

static void curvetri_rtc_set_geometry_bounds_function(struct CurvetriGeometry *geometry,
                                                      CurvetriBoundsFunction function)
{
  /* some versions ignore the function's own user pointer and pass the geometry's */
  rtcSetGeometryBoundsFunction((RTCGeometry)geometry, (RTCBoundsFunction)function,
                               rtcGetGeometryUserData((RTCGeometry)geometry));
}

static void curvetri_rtc_set_geometry_intersect_function(struct CurvetriGeometry *geometry,
                                                         CurvetriCallFunction function)
{
  rtcSetGeometryIntersectFunction((RTCGeometry)geometry, (RTCIntersectFunctionN)function);
}

static void curvetri_rtc_set_geometry_occluded_function(struct CurvetriGeometry *geometry,
                                                        CurvetriCallFunction function)
{
  rtcSetGeometryOccludedFunction((RTCGeometry)geometry, (RTCOccludedFunctionN)function);
}

static void curvetri_rtc_set_geometry_instanced_scene(struct CurvetriGeometry *geometry, struct CurvetriScene *scene)
{
  rtcSetGeometryInstancedScene((RTCGeometry)geometry, (RTCScene)scene);
}

static void curvetri_rtc_set_geometry_transform(struct CurvetriGeometry *geometry, unsigned int time_step,
                                                unsigned int format, const void *matrix)
{
  rtcSetGeometryTransform((RTCGeometry)geometry, time_step, (enum RTCFormat)format, matrix);
}

static struct CurvetriScene *curvetri_rtc_new_scene(struct CurvetriDevice *device)
{
  return (struct CurvetriScene *)rtcNewScene((RTCDevice)device);
}

static void curvetri_rtc_release_scene(struct CurvetriScene *scene) { rtcReleaseScene((RTCScene)scene); }

static void curvetri_rtc_set_scene_flags(struct CurvetriScene *scene, unsigned int flags)
{
  rtcSetSceneFlags((RTCScene)scene, (enum RTCSceneFlags)flags);
}

static void curvetri_rtc_set_scene_build_quality(struct CurvetriScene *scene, unsigned int quality)
{
  rtcSetSceneBuildQuality((RTCScene)scene, (enum RTCBuildQuality)quality);
}

static unsigned int curvetri_rtc_attach_geometry(struct CurvetriScene *scene, struct CurvetriGeometry *geometry)
{
  return rtcAttachGeometry((RTCScene)scene, (RTCGeometry)geometry);
}

static void curvetri_rtc_commit_scene(struct CurvetriScene *scene) { rtcCommitScene((RTCScene)scene); }

static void curvetri_rtc_get_scene_bounds(struct CurvetriScene *scene, struct CurvetriBounds *bounds)
{
  rtcGetSceneBounds((RTCScene)scene, (struct RTCBounds *)bounds);
}

/* The two kinds of query differ in their names alone, the two generations in how a query says what it wants. */
#if RTC_VERSION >= 40000

#define CURVETRI_PREPARE(Kind)                                          \
  struct RTC##Kind##Arguments arguments;                                \
  rtcInit##Kind##Arguments(&arguments);                                 \
  unsigned int flags = (unsigned int)arguments.flags;                   \
  if (query->coherent)                                                  \
    flags |= RTC_RAY_QUERY_FLAG_COHERENT;                               \
  if (query->filter)                                                    \
    flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;                 \
  arguments.flags = (enum RTCRayQueryFlags)flags;                       \
  arguments.filter = (RTCFilterFunctionN)query->filter;
#define CURVETRI_TRACE1(function, rays) function((RTCScene)scene, rays, &arguments)
#define CURVETRI_TRACE(function, rays) function(valid, (RTCScene)scene, rays, &arguments)

#else

#define CURVETRI_PREPARE(Kind)                                  \
  struct RTCIntersectContext context;                           \
  rtcInitIntersectContext(&context);                            \
  if (query->coherent)                                          \
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;        \
  context.filter = (RTCFilterFunctionN)query->filter;
#define CURVETRI_TRACE1(function, rays) function((RTCScene)scene, &context, rays)
#define CURVETRI_TRACE(function, rays) function(valid, (RTCScene)scene, &context, rays)

#endif

#define CURVETRI_QUERY(kind, Kind, Rays)                                                                 \
  static void curvetri_rtc_##kind(unsigned int width, const int *valid, struct CurvetriScene *scene,     \
                                  void *rays, const struct CurvetriQuery *query)                         \
  {                                                                                                      \
    CURVETRI_PREPARE(Kind)                                                                               \
    switch (width)                                                                                       \
    {                                                                                                    \
    case 1: CURVETRI_TRACE1(rtc##Kind##1, (struct Rays *)rays); break;                                   \
    case 4: CURVETRI_TRACE(rtc##Kind##4, (struct Rays##4 *)rays); break;                                 \
    case 8: CURVETRI_TRACE(rtc##Kind##8, (struct Rays##8 *)rays); break;                                 \
    case 16: CURVETRI_TRACE(rtc##Kind##16, (struct Rays##16 *)rays); break;                              \
    }                                                                                                    \
  }

CURVETRI_QUERY(intersect, Intersect, RTCRayHit)
CURVETRI_QUERY(occluded, Occluded, RTCRay)

/* 3.13 runs the geometry's and the query's filter; 4.x runs the geometry's alone. */
static void curvetri_rtc_filter_intersect(const struct CurvetriCall *call,
                                          const struct CurvetriCandidate *candidate,
                                          CurvetriFilterFunction query_filter)
{
  const struct RTCIntersectFunctionNArguments *arguments = (const struct RTCIntersectFunctionNArguments *)call;
  const struct RTCFilterFunctionNArguments *filtered = (const struct RTCFilterFunctionNArguments *)candidate;
#if RTC_VERSION >= 40000
  rtcInvokeIntersectFilterFromGeometry(arguments, filtered);
  if (query_filter)
    query_filter(candidate);
#else
  (void)query_filter;
  rtcFilterIntersection(arguments, filtered);
#endif
}

static void curvetri_rtc_filter_occluded(const struct CurvetriCall *call,
                                         const struct CurvetriCandidate *candidate,
                                         CurvetriFilterFunction query_filter)
{
  const struct RTCOccludedFunctionNArguments *arguments = (const struct RTCOccludedFunctionNArguments *)call;
  const struct RTCFilterFunctionNArguments *filtered = (const struct RTCFilterFunctionNArguments *)candidate;
#if RTC_VERSION >= 40000
  rtcInvokeOccludedFilterFromGeometry(arguments, filtered);
  if (query_filter)
    query_filter(candidate);
#else
  (void)query_filter;
  rtcFilterOcclusion(arguments, filtered);
#endif
}

/* Fills the table with the Embree that this translation unit calls. */
static inline void curvetri_embree_table(struct CurvetriEmbree *table)
{
  table->table_version = CURVETRI_TABLE_VERSION;
  table->table_size = sizeof(struct CurvetriEmbree);
  table->headers_version = RTC_VERSION;
  table->instance_levels = CURVETRI_LEVELS;
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
  table->inst_prim_id = 1;
#else
  table->inst_prim_id = 0;
#endif
  table->rayhit_size[0] = sizeof(struct RTCRayHit);
  table->rayhit_size[1] = sizeof(struct RTCRayHit4);
  table->rayhit_size[2] = sizeof(struct RTCRayHit8);
  table->rayhit_size[3] = sizeof(struct RTCRayHit16);
  table->context_inst_id = offsetof(CURVETRI_CONTEXT, instID);
#if RTC_VERSION >= 40000
  table->query_filter_scene_flag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
  table->query_filter_scene_flag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif

  table->new_device = curvetri_rtc_new_device;
  table->release_device = curvetri_rtc_release_device;
  table->get_device_property = curvetri_rtc_get_device_property;
  table->get_device_error = curvetri_rtc_get_device_error;
  table->set_device_error_function = curvetri_rtc_set_device_error_function;
  table->set_device_memory_monitor = curvetri_rtc_set_device_memory_monitor;

  table->new_geometry = curvetri_rtc_new_geometry;
  table->release_geometry = curvetri_rtc_release_geometry;
  table->commit_geometry = curvetri_rtc_commit_geometry;
  table->set_geometry_user_data = curvetri_rtc_set_geometry_user_data;
  table->set_geometry_mask = curvetri_rtc_set_geometry_mask;
  table->set_geometry_build_quality = curvetri_rtc_set_geometry_build_quality;
  table->set_geometry_time_step_count = curvetri_rtc_set_geometry_time_step_count;
  table->set_geometry_tessellation_rate = curvetri_rtc_set_geometry_tessellation_rate;
  table->set_new_geometry_buffer = curvetri_rtc_set_new_geometry_buffer;
  table->set_geometry_intersect_filter = curvetri_rtc_set_geometry_intersect_filter;
  table->set_geometry_occluded_filter = curvetri_rtc_set_geometry_occluded_filter;
  table->set_geometry_primitive_count = curvetri_rtc_set_geometry_primitive_count;
  table->set_geometry_bounds_function = curvetri_rtc_set_geometry_bounds_function;
  table->set_geometry_intersect_function = curvetri_rtc_set_geometry_intersect_function;
  table->set_geometry_occluded_function = curvetri_rtc_set_geometry_occluded_function;
  table->set_geometry_instanced_scene = curvetri_rtc_set_geometry_instanced_scene;
  table->set_geometry_transform = curvetri_rtc_set_geometry_transform;

  table->new_scene = curvetri_rtc_new_scene;
  table->release_scene = curvetri_rtc_release_scene;
  table->set_scene_flags = curvetri_rtc_set_scene_flags;
  table->set_scene_build_quality = curvetri_rtc_set_scene_build_quality;
  table->attach_geometry = curvetri_rtc_attach_geometry;
  table->commit_scene = curvetri_rtc_commit_scene;
  table->get_scene_bounds = curvetri_rtc_get_scene_bounds;

  table->intersect = curvetri_rtc_intersect;
  table->occluded = curvetri_rtc_occluded;
  table->filter_intersect = curvetri_rtc_filter_intersect;
  table->filter_occluded = curvetri_rtc_filter_occluded;
}

#ifdef __cplusplus
}
#endif

#endif

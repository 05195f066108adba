#include "shim.h"

/*
 * What src/embree/packet.rs and the callbacks rely on. A packet is arrays of `width` four-byte
 * fields: twelve of the ray, then the hit's seven, then instance ids by level.
 */
#define FIELD(type, field, index, width) \
  _Static_assert(offsetof(type, field) == 4 * (index) * (width), #type "." #field)

#define RAY_LAYOUT(type, width, alignment)                            \
  FIELD(type, org_x, 0, width);                                       \
  FIELD(type, tnear, 3, width);                                       \
  FIELD(type, dir_x, 4, width);                                       \
  FIELD(type, time, 7, width);                                        \
  FIELD(type, tfar, 8, width);                                        \
  FIELD(type, mask, 9, width);                                        \
  FIELD(type, id, 10, width);                                         \
  FIELD(type, flags, 11, width);                                      \
  _Static_assert(sizeof(type) == 48 * (width), "size of " #type);     \
  _Static_assert(_Alignof(type) == (alignment), "alignment of " #type)

#define LEVELS RTC_MAX_INSTANCE_LEVEL_COUNT
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
#define HIT_FIELDS (7 + 2 * LEVELS)
#define INSTANCE_LAYOUT(type, width) \
  FIELD(type, instID, 7, width);     \
  FIELD(type, instPrimID, 7 + LEVELS, width)
#else
#define HIT_FIELDS (7 + LEVELS)
#define INSTANCE_LAYOUT(type, width) FIELD(type, instID, 7, width)
#endif

/* rounded up to the alignment */
#define PADDED(size, alignment) (((size) + (alignment)-1) / (alignment) * (alignment))

#define HIT_LAYOUT(type, width, alignment)                                                           \
  FIELD(type, Ng_x, 0, width);                                                                       \
  FIELD(type, u, 3, width);                                                                          \
  FIELD(type, v, 4, width);                                                                          \
  FIELD(type, primID, 5, width);                                                                     \
  FIELD(type, geomID, 6, width);                                                                     \
  INSTANCE_LAYOUT(type, width);                                                                      \
  _Static_assert(sizeof(type) == PADDED(4 * HIT_FIELDS * (width), alignment), "size of " #type);     \
  _Static_assert(_Alignof(type) == (alignment), "alignment of " #type)

#define PACKET_LAYOUT(suffix, width, alignment)                                          \
  RAY_LAYOUT(struct RTCRay##suffix, width, alignment);                                   \
  HIT_LAYOUT(struct RTCHit##suffix, width, alignment);                                   \
  FIELD(struct RTCRayHit##suffix, ray, 0, width);                                        \
  FIELD(struct RTCRayHit##suffix, hit, 12, width);                                       \
  _Static_assert(sizeof(struct RTCRayHit##suffix) ==                                     \
                     sizeof(struct RTCRay##suffix) + sizeof(struct RTCHit##suffix),      \
                 "size of RTCRayHit" #suffix)

PACKET_LAYOUT(, 1, 16);
PACKET_LAYOUT(4, 4, 16);
PACKET_LAYOUT(8, 8, 32);
PACKET_LAYOUT(16, 16, 64);

#define AT(type, field, offset) _Static_assert(offsetof(struct type, field) == (offset), #type "." #field)

/* Pointers first: the same on every 64-bit system. */
_Static_assert(sizeof(void *) == 8, "curvetri needs a 64-bit system");
AT(RTCBounds, lower_x, 0);
AT(RTCBounds, upper_x, 16);
AT(RTCBoundsFunctionArguments, geometryUserPtr, 0);
AT(RTCBoundsFunctionArguments, primID, 8);
AT(RTCBoundsFunctionArguments, timeStep, 12);
AT(RTCBoundsFunctionArguments, bounds_o, 16);

#define CALL_LAYOUT(type, rays)     \
  AT(type, valid, 0);               \
  AT(type, geometryUserPtr, 8);     \
  AT(type, primID, 16);             \
  AT(type, context, 24);            \
  AT(type, rays, 32);               \
  AT(type, N, 40);                  \
  AT(type, geomID, 44);             \
  _Static_assert(sizeof(struct type) == 48, "size of " #type)
CALL_LAYOUT(RTCIntersectFunctionNArguments, rayhit);
CALL_LAYOUT(RTCOccludedFunctionNArguments, ray);

AT(RTCFilterFunctionNArguments, valid, 0);
AT(RTCFilterFunctionNArguments, geometryUserPtr, 8);
AT(RTCFilterFunctionNArguments, context, 16);
AT(RTCFilterFunctionNArguments, ray, 24);
AT(RTCFilterFunctionNArguments, hit, 32);
AT(RTCFilterFunctionNArguments, N, 40);
_Static_assert(sizeof(struct RTCFilterFunctionNArguments) == 48, "size of RTCFilterFunctionNArguments");

const struct CurvetriEmbree *curvetri_embree(void) { return &curvetri_linked_embree; }

unsigned int curvetri_headers_version(void) { return RTC_VERSION; }

unsigned int curvetri_query_filter_scene_flag(void)
{
#if CURVETRI_EMBREE == 4
  return RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
#else
  return RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
#endif
}

/* The two kinds of query differ in their names alone, the two versions in how a query says what it wants. */
#if CURVETRI_EMBREE == 4

#define PREPARE(kind, Kind)                                                     \
  struct RTC##Kind##Arguments arguments;                                        \
  rtcInit##Kind##Arguments(&arguments);                                         \
  if (query->coherent)                                                          \
    arguments.flags |= RTC_RAY_QUERY_FLAG_COHERENT;                             \
  if (query->filter)                                                            \
  {                                                                             \
    arguments.flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;               \
    arguments.filter = query->filter;                                           \
  }
#define TRACE1(function, rays) embree->function(scene, rays, &arguments)
#define TRACE(function, rays) embree->function(valid, scene, rays, &arguments)

#else

#define PREPARE(kind, Kind)                                          \
  struct RTCIntersectContext context;                                \
  rtcInitIntersectContext(&context);                                 \
  if (query->coherent)                                               \
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;             \
  context.filter = query->filter;
#define TRACE1(function, rays) embree->function(scene, &context, rays)
#define TRACE(function, rays) embree->function(valid, scene, &context, rays)

#endif

#define QUERY(kind, Kind, Rays)                                                                   \
  void curvetri_##kind(unsigned int width, const int *valid, RTCScene scene, void *rayhit,        \
                       const struct CurvetriQuery *query)                                         \
  {                                                                                               \
    const struct CurvetriEmbree *embree = curvetri_embree();                                      \
    PREPARE(kind, Kind)                                                                           \
    switch (width)                                                                                \
    {                                                                                             \
    case 1: TRACE1(kind##1, (struct Rays *)rayhit); break;                                        \
    case 4: TRACE(kind##4, (struct Rays##4 *)rayhit); break;                                      \
    case 8: TRACE(kind##8, (struct Rays##8 *)rayhit); break;                                      \
    case 16: TRACE(kind##16, (struct Rays##16 *)rayhit); break;                                   \
    }                                                                                             \
  }

QUERY(intersect, Intersect, RTCRayHit)
QUERY(occluded, Occluded, RTCRay)

#define FILTER(kind, Kind)                                                                \
  void curvetri_filter_##kind(const struct RTC##Kind##FunctionNArguments *call,           \
                              const struct RTCFilterFunctionNArguments *candidate,        \
                              RTCFilterFunctionN query_filter)                            \
  {                                                                                       \
    curvetri_embree()->filter_##kind(call, candidate);                                    \
    if (CURVETRI_EMBREE == 4 && query_filter)                                             \
      query_filter(candidate);                                                            \
  }

FILTER(intersect, Intersect)
FILTER(occluded, Occluded)

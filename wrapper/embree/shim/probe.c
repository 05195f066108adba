/* Preprocessed, never compiled: tells build.rs which Embree the compiler finds, and how it was built. */
#if CURVETRI_EMBREE == 4 && __has_include(<embree4/rtcore_config.h>)
#include <embree4/rtcore_config.h>
#elif CURVETRI_EMBREE == 3 && __has_include(<embree3/rtcore_config.h>)
#include <embree3/rtcore_config.h>
#endif

#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
#define INSTANCE_ARRAY 1
#else
#define INSTANCE_ARRAY 0
#endif

#ifdef RTC_VERSION
curvetri_probe RTC_VERSION RTC_MAX_INSTANCE_LEVEL_COUNT INSTANCE_ARRAY
#endif

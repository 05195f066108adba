/* Preprocessed, never compiled: tells build.rs which Embree the compiler finds. */
#if CURVETRI_EMBREE == 4 && __has_include(<embree4/rtcore_config.h>)
#include <embree4/rtcore_config.h>
#elif CURVETRI_EMBREE == 3 && __has_include(<embree3/rtcore_config.h>)
#include <embree3/rtcore_config.h>
#endif

#ifdef RTC_VERSION
curvetri_probe RTC_VERSION RTC_MAX_INSTANCE_LEVEL_COUNT
#endif

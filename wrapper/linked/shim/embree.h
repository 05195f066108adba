/* Embree's header of the generation that build.rs found: CURVETRI_EMBREE is 3 or 4. */
#if CURVETRI_EMBREE == 4
#include <embree4/rtcore.h>
#elif CURVETRI_EMBREE == 3
#include <embree3/rtcore.h>
#else
#error "CURVETRI_EMBREE must be 3 or 4"
#endif

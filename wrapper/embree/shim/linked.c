/* The one place that names Embree's functions: the table of the library this program links. */
#include "shim.h"

const struct CurvetriEmbree curvetri_linked_embree = {
    .new_device = rtcNewDevice,
    .release_device = rtcReleaseDevice,
    .get_device_property = rtcGetDeviceProperty,
    .get_device_error = rtcGetDeviceError,
    .set_device_error_function = rtcSetDeviceErrorFunction,
    .set_device_memory_monitor = rtcSetDeviceMemoryMonitorFunction,

    .new_geometry = rtcNewGeometry,
    .release_geometry = rtcReleaseGeometry,
    .commit_geometry = rtcCommitGeometry,
    .set_geometry_user_data = rtcSetGeometryUserData,
    .set_geometry_mask = rtcSetGeometryMask,
    .set_geometry_build_quality = rtcSetGeometryBuildQuality,
    .set_geometry_time_step_count = rtcSetGeometryTimeStepCount,
    .set_geometry_tessellation_rate = rtcSetGeometryTessellationRate,
    .set_new_geometry_buffer = rtcSetNewGeometryBuffer,
    .set_geometry_intersect_filter = rtcSetGeometryIntersectFilterFunction,
    .set_geometry_occluded_filter = rtcSetGeometryOccludedFilterFunction,
    .set_geometry_primitive_count = rtcSetGeometryUserPrimitiveCount,
    .set_geometry_bounds_function = rtcSetGeometryBoundsFunction,
    .set_geometry_intersect_function = rtcSetGeometryIntersectFunction,
    .set_geometry_occluded_function = rtcSetGeometryOccludedFunction,
    .set_geometry_instanced_scene = rtcSetGeometryInstancedScene,
    .set_geometry_transform = rtcSetGeometryTransform,

    .new_scene = rtcNewScene,
    .release_scene = rtcReleaseScene,
    .set_scene_flags = rtcSetSceneFlags,
    .set_scene_build_quality = rtcSetSceneBuildQuality,
    .attach_geometry = rtcAttachGeometry,
    .commit_scene = rtcCommitScene,
    .get_scene_bounds = rtcGetSceneBounds,

    .intersect1 = rtcIntersect1,
    .intersect4 = rtcIntersect4,
    .intersect8 = rtcIntersect8,
    .intersect16 = rtcIntersect16,
    .occluded1 = rtcOccluded1,
    .occluded4 = rtcOccluded4,
    .occluded8 = rtcOccluded8,
    .occluded16 = rtcOccluded16,
#if CURVETRI_EMBREE == 4
    .filter_intersect = rtcInvokeIntersectFilterFromGeometry,
    .filter_occluded = rtcInvokeOccludedFilterFromGeometry,
#else
    .filter_intersect = rtcFilterIntersection,
    .filter_occluded = rtcFilterOcclusion,
#endif
};

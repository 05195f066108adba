//! Embree's numbers and structs, the same for both generations. That they are is asserted here.

use std::mem::{align_of, offset_of, size_of};

pub(crate) use super::bindings::table::{
    CurvetriBounds, CurvetriBoundsCall, CurvetriCall, CurvetriCandidate, CurvetriDevice,
    CurvetriFilterFunction, CurvetriGeometry, CurvetriQuery, CurvetriScene,
};
use super::bindings::{embree_3, embree_4};

/// `RTC_INVALID_GEOMETRY_ID`, a macro with a cast that bindgen leaves out.
pub(crate) const INVALID_ID: u32 = u32::MAX;

/// Levels of nested instances that a hit has room for: what distributions build Embree with.
pub(crate) const LEVELS: usize = embree_4::RTC_MAX_INSTANCE_LEVEL_COUNT as usize;
const _: () = assert!(LEVELS == embree_3::RTC_MAX_INSTANCE_LEVEL_COUNT as usize);

/// Most time steps of a geometry.
pub(crate) const TIME_STEPS: u32 = embree_4::RTC_MAX_TIME_STEP_COUNT;
const _: () = assert!(TIME_STEPS == embree_3::RTC_MAX_TIME_STEP_COUNT);

/// Enumerators that have one value in both generations.
macro_rules! enumerators {
    ($($enumeration:ident { $($name:ident),+ $(,)? })+) => {$($(
        pub(crate) const $name: u32 = embree_4::$enumeration::$name.0;
        const _: () = assert!($name == embree_3::$enumeration::$name.0);
    )+)+};
}

enumerators! {
    RTCBufferType {
        RTC_BUFFER_TYPE_FACE,
        RTC_BUFFER_TYPE_GRID,
        RTC_BUFFER_TYPE_INDEX,
        RTC_BUFFER_TYPE_VERTEX,
    }
    RTCBuildQuality {
        RTC_BUILD_QUALITY_HIGH,
        RTC_BUILD_QUALITY_LOW,
        RTC_BUILD_QUALITY_MEDIUM,
    }
    RTCDeviceProperty {
        RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED,
        RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED,
        RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED,
        RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED,
        RTC_DEVICE_PROPERTY_VERSION,
    }
    RTCError {
        RTC_ERROR_CANCELLED,
        RTC_ERROR_INVALID_ARGUMENT,
        RTC_ERROR_INVALID_OPERATION,
        RTC_ERROR_NONE,
        RTC_ERROR_OUT_OF_MEMORY,
        RTC_ERROR_UNKNOWN,
        RTC_ERROR_UNSUPPORTED_CPU,
    }
    RTCFormat {
        RTC_FORMAT_FLOAT3,
        RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
        RTC_FORMAT_GRID,
        RTC_FORMAT_UINT,
        RTC_FORMAT_UINT3,
    }
    RTCGeometryType {
        RTC_GEOMETRY_TYPE_GRID,
        RTC_GEOMETRY_TYPE_INSTANCE,
        RTC_GEOMETRY_TYPE_SUBDIVISION,
        RTC_GEOMETRY_TYPE_TRIANGLE,
        RTC_GEOMETRY_TYPE_USER,
    }
    RTCSceneFlags {
        RTC_SCENE_FLAG_COMPACT,
        RTC_SCENE_FLAG_DYNAMIC,
        RTC_SCENE_FLAG_NONE,
        RTC_SCENE_FLAG_ROBUST,
    }
}

/// Fields of the table's structs that lie where both generations have them.
macro_rules! fields {
    ($($ours:ident is $theirs:ident { $($field:ident = $name:ident),+ $(,)? })+) => {
        $(fields!(embree_3 $ours $theirs $($field $name)+);
        fields!(embree_4 $ours $theirs $($field $name)+);)+
    };
    ($generation:ident $ours:ident $theirs:ident $($field:ident $name:ident)+) => {
        $(const _: () =
            assert!(offset_of!($ours, $field) == offset_of!($generation::$theirs, $name));)+
        const _: () = assert!(size_of::<$ours>() == size_of::<$generation::$theirs>());
        const _: () = assert!(align_of::<$ours>() <= align_of::<$generation::$theirs>());
    };
}

fields! {
    CurvetriBounds is RTCBounds { lower_x = lower_x, upper_x = upper_x }
    CurvetriBoundsCall is RTCBoundsFunctionArguments {
        user = geometryUserPtr,
        prim_id = primID,
        time_step = timeStep,
        bounds = bounds_o,
    }
    CurvetriCall is RTCIntersectFunctionNArguments {
        valid = valid,
        user = geometryUserPtr,
        prim_id = primID,
        context = context,
        rays = rayhit,
        width = N,
        geom_id = geomID,
    }
    CurvetriCall is RTCOccludedFunctionNArguments {
        valid = valid,
        user = geometryUserPtr,
        prim_id = primID,
        context = context,
        rays = ray,
        width = N,
        geom_id = geomID,
    }
    CurvetriCandidate is RTCFilterFunctionNArguments {
        valid = valid,
        user = geometryUserPtr,
        context = context,
        ray = ray,
        hit = hit,
        width = N,
    }
}

// Where a context has `instPrimID`, it lies behind `instID`, as in hits.
const _: () = assert!(
    offset_of!(embree_4::RTCRayQueryContext, instPrimID)
        == offset_of!(embree_4::RTCRayQueryContext, instID) + 4 * LEVELS
);

//! Cameras, lights, film: pictures.

//! A safe wrapper over the installed Embree, 3.13 or 4.x.

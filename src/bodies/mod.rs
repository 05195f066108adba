//! Bodies with a known true surface, and meshes made by programs.

//! What every ray gets, whatever it goes through: packets of every width, filters, instances, all hits along a
//! ray, rays that start on a surface, and flat triangles among curved ones.

mod all_hits;
mod far_rays;
mod filters;
mod glass;
mod instances;
mod packets;
mod queries;
mod secondary_rays;
mod tolerance;

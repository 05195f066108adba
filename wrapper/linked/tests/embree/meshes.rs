//! Embree's grids and subdivision surfaces.

use glam::Vec3;

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

/// The unit square at z = 1 as a grid of 4 by 3 vertices, with a vertex before it and one more a row.
fn grid() -> (Vec<Vec3>, Grid) {
    let mut vertices = vec![Vec3::splat(9.0)];
    for row in 0..3 {
        vertices.extend((0..4).map(|i| Vec3::new(i as f32 / 3.0, row as f32 / 2.0, 1.0)));
        vertices.push(Vec3::splat(-9.0));
    }
    let grid = Grid {
        first: 1,
        stride: 5,
        width: 4,
        height: 3,
    };
    (vertices, grid)
}

/// Rays upwards through a point of the plane z = 1.
fn upwards(through: &[[f32; 2]]) -> Vec<Ray> {
    let from = |&[x, y]: &[f32; 2]| Ray::new(Vec3::new(x, y, 0.0), Vec3::Z);
    through.iter().map(from).collect()
}

/// All widths and flags, as each gives the rays' hits and shadows.
fn traced(scene: &Scene, rays: &[Ray]) -> [(Vec<Option<Hit>>, Vec<bool>); 4] {
    let (coherent, incoherent) = (QueryOptions::COHERENT, QueryOptions::INCOHERENT);
    [
        (
            hits::<1>(scene, rays, &incoherent),
            shadows::<1>(scene, rays, &incoherent),
        ),
        (
            hits::<4>(scene, rays, &coherent),
            shadows::<4>(scene, rays, &coherent),
        ),
        (
            hits::<8>(scene, rays, &coherent),
            shadows::<8>(scene, rays, &coherent),
        ),
        (
            hits::<16>(scene, rays, &coherent),
            shadows::<16>(scene, rays, &coherent),
        ),
    ]
}

#[test]
fn grids_are_hit_where_they_are() {
    let (vertices, grid) = grid();
    let points = [[0.1, 0.2], [0.9, 0.2], [0.4, 0.9], [1.1, 0.5], [0.5, -0.1]];
    let rays = upwards(&points);
    for device in devices() {
        let scene = scene_of(
            &device,
            Geometry::grids(&device, &vertices, &[grid, grid]).unwrap(),
        );
        for (hits, shadows) in traced(&scene, &rays) {
            for ((point, hit), shadow) in points.iter().zip(hits).zip(shadows) {
                let inside = point.iter().all(|x| (0.0..=1.0).contains(x));
                assert_eq!((hit.is_some(), shadow), (inside, inside), "{point:?}");
                let Some(hit) = hit else { continue };
                assert!((hit.t - 1.0).abs() < 1e-6 && hit.prim_id < 2);
                let off = Vec3::new(hit.u - point[0], hit.v - point[1], 0.0);
                assert!(off.length() < 1e-5, "{hit:?}");
            }
        }
    }
}

#[test]
fn quadrangles_of_a_grid_fold_along_the_diagonal_that_is_promised() {
    // raised at the second vertex of the first row and the first of the second: a ridge between
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, 5.0 + z);
    let vertices = [
        at(0., 0., 0.),
        at(1., 0., 1.),
        at(0., 1., 1.),
        at(1., 1., 0.),
    ];
    let grid = Grid {
        first: 0,
        stride: 2,
        width: 2,
        height: 2,
    };
    for device in devices() {
        let scene = scene_of(
            &device,
            Geometry::grids(&device, &vertices, &[grid]).unwrap(),
        );
        let hits = hits::<1>(&scene, &upwards(&[[0.45, 0.45]]), &QueryOptions::default());
        assert!((hits[0].unwrap().t - 5.9).abs() < 1e-5, "{hits:?}");
    }
}

#[test]
fn grids_out_of_range_are_refused() {
    let device = linked::device().unwrap();
    let (vertices, good) = grid();
    for grid in [
        Grid { first: 3, ..good },
        Grid { height: 4, ..good },
        Grid {
            stride: u32::MAX,
            ..good
        },
        Grid { width: 1, ..good },
        Grid { height: 0, ..good },
        Grid {
            width: 1,
            height: 40000,
            ..good
        },
    ] {
        let refused = Geometry::grids(&device, &vertices, &[good, grid]).err();
        let vertices = vertices.len();
        let expected = Error::Grid {
            number: 1,
            grid,
            vertices,
        };
        assert_eq!(refused, Some(expected));
    }
}

/// An octahedron around the origin.
fn octahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]];
    let below = faces.map(|[a, b, _]| [b, a, 5]);
    (vec![x, -x, y, -y, z, -z], [faces, below].concat())
}

#[test]
fn a_subdivision_surface_is_round_and_inside_its_mesh() {
    let (vertices, faces) = octahedron();
    let rays: Vec<Ray> = random_rays(200, 9)
        .into_iter()
        .map(|ray| Ray::new(Vec3::ZERO, ray.direction.normalize()))
        .collect();
    for device in devices() {
        let surface = Geometry::subdivision(&device, &vertices, &faces, 8).unwrap();
        let scene = scene_of(&device, surface);
        for (hits, shadows) in traced(&scene, &rays) {
            assert!(
                shadows.into_iter().all(|shadow| shadow),
                "the surface is closed"
            );
            for (ray, hit) in rays.iter().zip(hits) {
                let hit = hit.expect("the surface is closed");
                let flat = 1.0 / ray.direction.abs().element_sum();
                assert!(hit.t < flat + 1e-6 && hit.t > 0.35, "{hit:?}");
                assert!((hit.prim_id as usize) < faces.len());
                // the coarse normal of the octahedron is up to 55 degrees off
                assert!(hit.ng.normalize().dot(ray.direction) > 0.8, "{hit:?}");
            }
        }
    }
}

#[test]
fn what_no_subdivision_can_be_made_of_is_refused() {
    let device = linked::device().unwrap();
    let (vertices, faces) = octahedron();
    for level in [0, Geometry::FINEST_LEVEL + 1] {
        let refused = Geometry::subdivision(&device, &vertices, &faces, level).err();
        assert_eq!(refused, Some(Error::Level(level)));
    }
    let refused = Geometry::subdivision(&device, &vertices[..5], &faces, 4).err();
    assert!(matches!(
        refused,
        Some(Error::Index {
            triangle: 4,
            index: 5,
            ..
        })
    ));
}

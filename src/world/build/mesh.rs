//! Meshes made in code: those of a file are whole, but these may hold anything.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::mesh::{MeshGroup, MeshNormals};
use crate::printable::counted;
use crate::scene::MeshFile;

/// What is wrong with the meshes that were looked at, by their places in memory: each is looked at
/// once, however many objects have it.
#[derive(Default)]
pub(super) struct Checked(HashMap<usize, Result<(), String>>);

impl Checked {
    /// Whether everything in a mesh is there that it names; else what is not.
    pub(super) fn check(&mut self, mesh: &Arc<MeshFile>) -> Result<(), String> {
        let place = Arc::as_ptr(mesh).addr();
        self.0.entry(place).or_insert_with(|| check(mesh)).clone()
    }
}

fn check(mesh: &MeshFile) -> Result<(), String> {
    let MeshFile {
        positions,
        triangles,
        normals,
        groups,
        ..
    } = mesh;
    if triangles.is_empty() {
        return Err("the mesh has no triangles, expected at least one".to_owned());
    }
    if let Some(index) = first(positions, |position| {
        !position.iter().all(|x| x.is_finite())
    }) {
        return Err(format!(
            "position {index} of the mesh is {:?}, expected three finite numbers",
            positions[index],
        ));
    }
    named_ones_exist(triangles, positions.len(), "position")?;
    if let Some(normals) = normals {
        check_normals(normals, triangles)?;
    }
    check_groups(groups, triangles.len())
}

fn check_normals(normals: &MeshNormals, triangles: &[[u32; 3]]) -> Result<(), String> {
    let MeshNormals {
        vectors,
        triangles: own,
    } = normals;
    if let Some(index) = first(vectors, |normal| !normal.iter().all(|x| x.is_finite())) {
        return Err(format!(
            "normal {index} of the mesh is {:?}, expected three finite numbers",
            vectors[index],
        ));
    }
    if let Some(own) = own
        && own.len() != triangles.len()
    {
        return Err(format!(
            "the mesh has {}, but indices of normals for {}, expected as many",
            counted(triangles.len(), "triangle", "triangles"),
            own.len(),
        ));
    }
    let named = own.as_deref().unwrap_or(triangles);
    named_ones_exist(named, vectors.len(), "normal")?;
    if first(vectors, |normal| *normal == [0.0; 3]).is_none() {
        return Ok(());
    }
    let is_zero = |&index: &u32| vectors[index as usize] == [0.0; 3];
    if let Some(index) = first(named, |corners| corners.iter().any(is_zero)) {
        return Err(format!(
            "a normal of triangle {index} of the mesh is [0, 0, 0], expected a direction",
        ));
    }
    Ok(())
}

/// Groups follow each other without overlap, and none is empty.
fn check_groups(groups: &[MeshGroup], triangles: usize) -> Result<(), String> {
    let mut end = 0;
    for MeshGroup {
        name,
        triangles: Range { start, end: next },
    } in groups
    {
        if *start < end || next <= start || *next as usize > triangles {
            return Err(format!(
                "the group `{}` of the mesh has triangles {start} to {next}, expected some of \
                 {end} to {triangles}: groups follow each other, and none is empty",
                crate::printable::printable(name),
            ));
        }
        end = *next;
    }
    Ok(())
}

/// Whether all indices of triangles are below `count`.
fn named_ones_exist(triangles: &[[u32; 3]], count: usize, what: &str) -> Result<(), String> {
    let is_beyond = |&index: &u32| index as usize >= count;
    let largest = |&[a, b, c]: &[u32; 3]| a.max(b).max(c);
    let Some(index) = first(triangles, |corners| is_beyond(&largest(corners))) else {
        return Ok(());
    };
    let beyond = triangles[index].iter().find(|index| is_beyond(index));
    Err(format!(
        "triangle {index} of the mesh names {what} {}, but the mesh has {count}, counted from 0",
        beyond.expect("the triangle was found by it"),
    ))
}

/// The place of the first item that is wrong.
fn first<T: Sync>(items: &[T], is_wrong: impl Fn(&T) -> bool + Sync + Send) -> Option<usize> {
    /// Items that are looked at before anyone asks whether one was wrong.
    const RUN: usize = 1 << 12;
    let runs = items.par_chunks(RUN);
    let any = |run: &[T]| run.iter().fold(false, |any, item| any | is_wrong(item));
    let start = runs.position_first(any)? * RUN;
    let place = items[start..].iter().position(is_wrong)?;
    Some(start + place)
}

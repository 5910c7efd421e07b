use super::*;

/// Shapes in a leaf.
const LEAF_SIZE: usize = 2;

/// Cubes of half the size `half` around centers.
fn cubes(centers: impl Iterator<Item = [f32; 3]>, half: f32) -> Vec<Item> {
    let cube = |(index, center): (usize, [f32; 3])| {
        let center = Vec3::from_array(center);
        Item::new(center - half, center + half, index as u32)
    };
    centers.enumerate().map(cube).collect()
}

/// Points without order in the unit cube: multiples of three irrational numbers.
fn scattered(count: u32) -> impl Iterator<Item = [f32; 3]> {
    const STEPS: [f64; 3] = [
        0.819_172_513_396_164,
        0.671_043_606_703_789,
        0.549_700_477_901_97,
    ];
    (0..count).map(|i| STEPS.map(|step| (f64::from(i) * step).fract() as f32))
}

/// Each half as far from a point as the one before: parting by surface takes off one at a time.
fn approaching(count: u32, copies: u32) -> impl Iterator<Item = [f32; 3]> {
    (0..count).map(move |i| [0.5_f32.powi((i / copies) as i32), 0.0, 0.0])
}

/// The tree over items.
fn built(items: &[Item]) -> (Vec<BuildNode>, Vec<u32>) {
    built_but(items, &[])
}

/// The same without a few of them.
fn built_but(items: &[Item], listed: &[u32]) -> (Vec<BuildNode>, Vec<u32>) {
    let Box4 { min, max } = bounds_of(items);
    let bounds = [min.truncate(), max.truncate()];
    let item = |index: u32| items[index as usize];
    build(items.len() as u32, listed, bounds, &item, LEAF_SIZE)
}

/// Checks that boxes hold what is below them and that each shape is in one leaf; the depth.
#[track_caller]
fn check(items: &[Item]) -> usize {
    let (nodes, order) = built(items);
    let mut indices = order.clone();
    indices.sort_unstable();
    assert!(indices.iter().copied().eq(0..items.len() as u32));

    let mut known_shape = vec![0; items.len()];
    let mut open = vec![(0, Vec3::NEG_INFINITY, Vec3::INFINITY, 1)];
    let mut visited = 0;
    let mut deepest = 0;
    while let Some((node, min, max, depth)) = open.pop() {
        visited += 1;
        deepest = deepest.max(depth);
        assert!(!nodes[node].members().is_empty());
        for member in nodes[node].members() {
            let holds = |inner_min: Vec3, inner_max: Vec3, min: Vec3, max: Vec3| {
                assert!(min.cmple(inner_min).all() && inner_max.cmple(max).all());
            };
            holds(member.min, member.max, min, max);
            match member.child {
                Child::Node(child) => {
                    open.push((child as usize, member.min, member.max, depth + 1));
                }
                Child::Leaf { first, count } => {
                    for place in first..first + count {
                        known_shape[place as usize] += 1;
                        let Box4 { min, max } = items[order[place as usize] as usize].bounds;
                        holds(min.truncate(), max.truncate(), member.min, member.max);
                    }
                }
            }
        }
    }
    assert_eq!(visited, nodes.len(), "every node has one parent");
    assert!(
        known_shape.iter().all(|&times| times == 1),
        "one leaf for each"
    );
    deepest
}

#[test]
fn every_shape_is_in_one_leaf_and_in_all_boxes_above() {
    for count in [1, 2, 7, 8, 9, 63, 64, 65, 1000, 4096, 4097, 70_000, 300_000] {
        let deepest = check(&cubes(scattered(count), 1e-3));
        // Full nodes would take log₈.
        let expected = 2 + (f64::from(count).log2() / 2.0).ceil() as usize;
        assert!(deepest <= expected, "{deepest} levels over {count}");
    }
}

#[test]
fn the_tree_is_the_same_for_any_number_of_threads() {
    let items = cubes(scattered(200_000), 1e-3);
    let built_by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| built(&items))
    };
    let one = built_by(1);
    for threads in [2, 3, 8] {
        assert!(built_by(threads) == one, "{threads} threads");
    }
}

#[test]
fn shapes_of_one_center_share_a_leaf() {
    let center = [0.3, -0.2, 0.1];
    let copies = (0..100_000).map(|_| center);
    assert_eq!(check(&cubes(copies, 0.5)), 1);
    // Beside others as well.
    let others = scattered(100_000).chain((0..100_000).map(|_| center));
    let items = cubes(others, 1e-3);
    check(&items);
    let (nodes, _) = built(&items);
    let sizes = nodes.iter().flat_map(BuildNode::members);
    let sizes = sizes.filter_map(|member| match member.child {
        Child::Leaf { count, .. } => Some(count),
        Child::Node(_) => None,
    });
    assert_eq!(sizes.max(), Some(100_000));
}

#[test]
fn no_arrangement_makes_a_deep_tree() {
    const MOST: usize = BY_SURFACE as usize + 18;
    for copies in [1, 3, 1000] {
        let deepest = check(&cubes(approaching(100 * copies, copies), 0.0));
        assert!(deepest <= MOST, "{deepest} levels of {copies} copies");
    }
    // Sizes far beyond each other, down to where f32 ends.
    let series = (0..250_u32).flat_map(|i| {
        let size = 0.5_f32.powi((i % 140) as i32);
        [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, -size]]
    });
    assert!(check(&cubes(series, 0.0)) <= MOST);
}

#[test]
fn what_is_apart_is_parted_first() {
    // Two clusters of unlike numbers, far from each other.
    let near = scattered(5000);
    let far = scattered(500).map(|[x, y, z]| [x + 100.0, y, z]);
    let (nodes, _) = built(&cubes(near.chain(far), 1e-3));
    let across = |member: &Member| member.min.x < 50.0 && member.max.x > 50.0;
    assert!(!nodes[0].members().iter().any(across));
}

/// Whatever fills the grid's cells: a plane, a line, one place, one place beside many, all of them far apart.
#[test]
fn a_grid_may_be_filled_in_any_way() {
    let count = 2 * grid::LEAST as u32;
    let flat = scattered(count).map(|[x, y, _]| [x, y, 0.5]);
    check(&cubes(flat, 1e-4));
    let line = scattered(count).map(|[x, _, _]| [0.0, x, 0.0]);
    check(&cubes(line, 0.0));
    let crowd = || scattered(count).map(|place| place.map(|x| x * 1e-4));
    let few = scattered(100).map(|place| place.map(|x| x * 0.9));
    check(&cubes(crowd().chain(few), 1e-6));
    check(&cubes(
        crowd().chain([[-1.0, 0.3, 0.2], [0.9, -1.0, 1.0]]),
        1e-6,
    ));
    check(&cubes((0..count).map(|_| [0.25; 3]), 0.0));
}

#[test]
fn listed_shapes_are_left_out() {
    for count in [1000, 2 * grid::LEAST as u32] {
        let items = cubes(scattered(count), 1e-3);
        let listed = [0, 7, count / 2, count - 1];
        let (_, mut order) = built_but(&items, &listed);
        order.sort_unstable();
        let others = (0..count).filter(|number| !listed.contains(number));
        assert!(order.into_iter().eq(others), "{count} shapes");
    }
}

#[test]
fn indices_survive() {
    for index in [0, 1, 0xffff, 0x1_0000, 0x1234_5678, u32::MAX] {
        assert_eq!(Item::new(Vec3::ZERO, Vec3::ONE, index).index(), index);
    }
}

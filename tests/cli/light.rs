//! `candela light` and `candela lux`.

use std::fs;

use super::{fails, succeeds};

const LAMP: &str = "tests/bad_scenes/lamp.ies";

#[test]
fn an_ies_file_in_numbers_and_as_a_diagram() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(LAMP, folder.path().join("lamp.ies")).unwrap();
    for diagram in ["polar.svg", "polar.png"] {
        let text = succeeds(folder.path(), &format!("light lamp.ies -o {diagram}"));
        for part in [
            "type C",
            "100 cd at V 0°",
            "351.161 lm, of the bilinear table",
            "absolute",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        let bytes = fs::read(folder.path().join(diagram)).unwrap();
        let is_one = bytes.starts_with(b"<svg") || bytes.starts_with(b"\x89PNG");
        assert!(is_one, "{diagram}");
    }
    for (arguments, part) in [
        (
            "light lamp.ies -o polar.jpg",
            "end it with `.svg` or `.png`",
        ),
        ("light lamp.ies -o lamp.ies", "give another name"),
        ("light missing.ies", "cannot use the IES file missing.ies"),
    ] {
        let text = fails(folder.path(), arguments, 1);
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_working_plane_in_lux() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[image]\nresolution = [8, 8]\n[camera.perspective]\neye = [0, 1, 4]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
                 [materials.m.phong]\ndiffuse = 0.5\n\
                 [lights.lamp.point]\nposition = [0, 2, 0]\nintensity = 100\n\
                 [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n";
    fs::write(folder.path().join("room.toml"), scene).unwrap();
    let plane = "--from -0.5,0,0.5 --u 1,0,0 --v 0,0,-1";
    let text = succeeds(
        folder.path(),
        &format!("lux room.toml {plane} --grid 1 -o grid.csv"),
    );
    for part in [
        "mean           25 lx",
        "U0  1.000",
        "direct component only",
        "1 × 1",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let csv = fs::read_to_string(folder.path().join("grid.csv")).unwrap();
    assert_eq!(csv, "x,y,z,lux\n0,0,0,25\n");
    for (arguments, part) in [
        ("--from 0,0,0 --u 1,0,0 --v 2,0,0", "span no plane"),
        (
            "--from 0,0,0 --u 1,0,0 --v 0,0,1e9 --grid 1e-3",
            "choose a larger --grid",
        ),
    ] {
        let text = fails(folder.path(), &format!("lux room.toml {arguments}"), 1);
        assert!(text.contains(part), "{text}");
    }
    fails(
        folder.path(),
        "lux room.toml --from 0,0 --u 1,0,0 --v 0,0,1",
        2,
    );
}

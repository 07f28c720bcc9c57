use super::*;
use crate::color::Srgb8;
use crate::scene::{DepthOfField, Item, LightFrame, Scene};

fn selection(text: &str) -> Selection {
    Selection::parse(text).unwrap()
}

fn settings() -> Settings {
    let document = crate::import::read_bytes(b"2\n\nO 1 2 3\nO 4 2 3\n", "a.xyz", &Default::default()).unwrap();
    let scene = Scene::new(&[Item::of(&document.records[0])], &SceneOptions::default());
    let viewpoint = Viewpoint::of(&scene, &scene.fitted_camera(1.5));
    Settings {
        scene: SceneOptions {
            style: Style::Licorice,
            color_by: ColorBy::Chain,
            look: Look::Dark,
            background: Background::Transparent,
            ground: false,
            perspective: false,
            hydrogens: false,
            ions: false,
            by_selection: BySelection {
                show: vec![selection("chain A or ligand")],
                hide: vec![selection("file 2 and index 1-3"), selection("water")],
                colors: vec![(selection("bfactor = 30"), Srgb8::rgb(255, 0, 0))],
                styles: vec![(selection("ligand"), Style::SpaceFilling)],
                labels: vec![selection("name CA")],
            },
            ball_scale: 1.5,
            stick_scale: 0.5,
            altloc: AltlocChoice::Code(b'B'),
            vectors: VectorChoice::from_name("forces"),
            vector_scale: Some(0.5),
            text: OverlayOptions {
                labels: LabelContent { element: true, index: true, ..LabelContent::default() },
                size: 1.5,
                legend: true,
                scale_bar: true,
            },
            pose: Some(viewpoint.pose),
            light: LightFrame::World,
            fog: Some(0.5),
            outline: Some(0.0015),
            outline_color: Srgb8::parse("navy"),
            depth_of_field: Some(DepthOfField { blur: 0.012, focus: 0.75 }),
            overlay_opacity: Some(0.25),
            overlay_wireframe: true,
            overlay_color: Srgb8::parse("teal"),
            ..SceneOptions::default()
        },
        crystal: CrystalOptions {
            cell: CellChoice::Full,
            supercell: [2, 1, 3],
            assembly: AssemblyId::new("PAU"),
            bonds: BondOptions { mode: BondMode::Perceive, hydrogen_bonds: true, ..BondOptions::default() },
            ..CrystalOptions::default()
        },
        cell_box: Some(false),
        quality: Quality::High,
        viewpoint: Some(viewpoint),
    }
}

/// With a file and a picture.
pub(super) fn session() -> Session {
    let mut session = Session::of(&settings());
    session.files.push(File {
        path: "a.xyz".into(),
        frame: 3,
        visible: true,
        sha256: Some("0".repeat(64)),
        ..File::default()
    });
    session.picture = Some(Picture {
        size: "85mmx60mm".to_owned(),
        dpi: Some(600),
        region: Some("1,2,3,4".to_owned()),
        crop: None,
        samples: 4,
        ao: 16,
        channel: "color".to_owned(),
        renderer: "cpu".to_owned(),
        view: Some("front".to_owned()),
        axis: None,
        record: None,
        turntable: Some(12),
        frames: None,
        fps: Some(12.5),
    });
    session
}

#[test]
fn settings_come_back_through_json() {
    let mut session = session();
    session.overlay.push(Overlay { path: "/meshes/a.obj".into(), sha256: None });
    session.measurements.push(vec![[1, 1], [1, 2]]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.json");
    let file = folder.path().join("sub/a.xyz");
    session.files[0].path = file.clone();
    session.write(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("\"sub/a.xyz\"") && Session::is_one(text.as_bytes()), "{text}");
    let read = Session::read(&path).unwrap();
    assert_eq!((&read.files[0].path, read.files[0].frame), (&file, 3));
    assert_eq!((&read.measurements, &read.overlay), (&session.measurements, &session.overlay));
    assert_eq!((&read.picture, &read.files[0].sha256), (&session.picture, &session.files[0].sha256));
    let again = read.settings().unwrap();
    let (a, b) = (again.viewpoint.unwrap(), settings().viewpoint.unwrap());
    assert!(a.target.distance(b.target) < 1e-5 && a.pose.center == b.pose.center);
    let mut expected = settings();
    (expected.viewpoint, expected.scene.pose) = (again.viewpoint, again.scene.pose);
    assert_eq!(again, expected);
}

#[test]
fn what_means_nothing_is_refused_with_what_is_meant() {
    let good = serde_json::to_value(Session::of(&settings())).unwrap();
    let refused = |field: &str, value: serde_json::Value| {
        let mut bad = good.clone();
        bad[field] = value;
        Session::parse(&serde_json::to_vec_pretty(&bad).unwrap(), Path::new("")).unwrap_err().to_string()
    };
    assert!(Session::parse(good.to_string().as_bytes(), Path::new("")).is_ok());
    assert!(refused("style", "cartoon".into()).contains("style: found \"cartoon\", expected one of ball-and-stick, "));
    assert!(refused("supercell", serde_json::json!([1, 0, 1])).contains("from 1 to 10000"));
    assert!(refused("assembly", "".into()).contains("id of an assembly"));
    assert!(refused("camera", "here".into()).contains("sixteen or twenty-one numbers"));
    assert!(refused("label", serde_json::json!(["colour"])).contains("element, index"));
    assert!(refused("colour", "red".into()).contains("unknown field `colour`"));
    assert!(refused("hide", serde_json::json!(["chian A"])).contains("session: hide: "));
    assert!(refused("hide", serde_json::json!(["chian A"])).contains("did you mean `chain`?"));
    assert!(refused("color", serde_json::json!(["chain A"])).contains("a selection, = and a value"));
    assert!(refused("styles", serde_json::json!(["chain A=thick"])).contains("one of ball-and-stick"));
    assert!(refused("ball_scale", 0.into()).contains("from 0.1 to 10"));
    assert!(refused("ground", "yes".into()).starts_with("line "));
    assert!(refused("ballstick_session", 9.into()).contains("version 9"));
    assert!(refused("measurements", serde_json::json!([[[1, 1], [1, 2]]])).contains("number of a file"));
    for bad in ["", "{", "[]", "{\"ballstick_session\": 1}"] {
        assert!(Session::parse(bad.as_bytes(), Path::new("")).is_err(), "{bad}");
    }
    for name in ["-", "sample:caffeine"] {
        let mut named = session();
        named.files[0].path = name.into();
        let text = named.text(None).1;
        assert_eq!(Session::parse(text.as_bytes(), Path::new("/folder")).unwrap().files[0].path, Path::new(name));
    }
    assert!(!Session::is_one(b"{\"atoms\": []}") && !Session::is_one(b"HEADER \"ballstick_session\""));
}

#[test]
fn the_command_line_says_what_is_not_usual() {
    let plain = Settings {
        scene: SceneOptions::default(),
        crystal: CrystalOptions::default(),
        cell_box: None,
        quality: Quality::Standard,
        viewpoint: None,
    };
    let file = |path: &str, visible| File { path: path.into(), frame: 1, visible, ..File::default() };
    let mut session = Session::of(&plain);
    session.files = vec![file("it's here.pdb", true)];
    assert_eq!(session.command_line([640, 480]), r"ballstick render 'it'\''s here.pdb' -o picture.png --size 640x480");
    let mut session = Session::of(&settings());
    session.files = vec![file("hidden.pdb", false), file("-a.pdb", true), file("b.pdb", true)];
    session.measurements = vec![vec![[2, 5], [3, 7]], vec![[1, 1], [2, 2]]];
    let line = session.command_line([10, 20]);
    assert!(line.starts_with("ballstick render ./-a.pdb b.pdb -o picture.png --size 10x20 --style licorice"), "{line}");
    for words in [
        "--background transparent",
        "--label element,index --label-size 1.5",
        "--supercell 2x1x3",
        "--assembly PAU",
        "--measure 5,2:7 --camera ",
        "--show 'chain A or ligand' --hide 'file 1 and index 1-3' --hide water --label-only 'name CA'",
        "--style ligand=space-filling --color 'bfactor = 30=#ff0000' --ball-scale 1.5 --stick-scale 0.5",
        "--no-ground --no-hydrogens --no-ions --legend --scale-bar --hbonds --no-cell-box",
    ] {
        assert!(line.contains(words), "{words} in {line}");
    }
    assert!(!line.contains("hidden") && line.matches("--measure").count() == 1);
}

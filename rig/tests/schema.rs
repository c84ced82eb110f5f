//! The schema in docs/ is the reader's own, and accepts what the reader accepts.

use boon::{Compiler, SchemaIndex, Schemas};
use pneudrive_rig::Rig;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/rig.schema.json");
const PAGE: &str = include_str!("../../docs/rig.md");

fn compiled() -> (Schemas, SchemaIndex) {
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.add_resource("rig.json", pneudrive_rig::schema()).expect("the schema is taken");
    let index = compiler.compile("rig.json", &mut schemas).expect("the schema compiles");
    (schemas, index)
}

/// `PNEUDRIVE_UPDATE=1` writes it anew.
#[test]
fn the_file_in_docs_is_this_schema() {
    let text = serde_json::to_string_pretty(&pneudrive_rig::schema()).unwrap() + "\n";
    if std::env::var_os("PNEUDRIVE_UPDATE").is_some() {
        std::fs::write(FILE, &text).unwrap();
    }
    // Their keys may stand in another order.
    let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(FILE).unwrap()).unwrap();
    assert_eq!(file, pneudrive_rig::schema(), "PNEUDRIVE_UPDATE=1 writes docs/rig.schema.json anew");
}

/// The annotated example has every key that there is, and is read.
#[test]
fn the_example_in_docs_is_whole() {
    let example = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let rig = Rig::parse("docs/rig.md", example).unwrap();
    let mut missing = Vec::new();
    keys(&pneudrive_rig::schema(), String::new(), &mut missing);
    // Of the two ways to describe a chamber each table has one, and the example has both.
    let somewhere = |key: &str| {
        ["chamber", "boards.0.chamber", "boards.0.channels.3.chamber"]
            .iter()
            .any(|table| rig.line(&format!("{table}.{key}")).is_some())
    };
    missing.retain(|path| match path.split_once("chamber.") {
        Some((_, key)) => !somewhere(key),
        None => rig.line(path).is_none(),
    });
    assert_eq!(missing, Vec::<String>::new());
}

/// Paths of all keys; board 0 and channel 3 stand for all.
fn keys(schema: &serde_json::Value, path: String, found: &mut Vec<String>) {
    let join = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    for (name, inner) in schema["properties"].as_object().expect("it has properties") {
        if inner["type"] == "object" {
            keys(inner, join(name), found);
        } else {
            found.push(join(name));
        }
    }
    for inner in schema["patternProperties"].as_object().into_iter().flat_map(|map| map.values()) {
        keys(inner, join(if path.is_empty() || path == "boards" { "0" } else { "3" }), found);
    }
}

#[test]
fn schema_and_reader_agree() {
    let (schemas, index) = compiled();
    let example = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    for (text, good) in [
        (example, true),
        ("", true),
        ("[limits]\nmax_kpa = 0\n", true),
        ("[limits]\nmax_kpa = 2000\n", true),
        ("[limits]\nmax_kpa = 2000.1\n", false),
        ("[limits]\nmax_kpa = -0.1\n", false),
        ("[limits]\nmax_kpa = \"3\"\n", false),
        ("[limits]\nmax_rate_kpa_s = 0\n", false),
        ("[limits]\nmax_rate_kpa_s = 0.1\n", true),
        ("[limits]\nmax = 1\n", false),
        ("[limit]\n", false),
        ("limits = 3\n", false),
        ("[boards.255]\n", true),
        ("[boards.256]\n", false),
        ("[boards.00]\n", false),
        ("[boards.1.channels.3]\nname = \"x\"\n", true),
        ("[boards.1.channels.4]\nname = \"x\"\n", false),
        ("[boards.1.channels.3]\nname = \"\"\n", false),
        ("[boards.1.channels.3]\nname = \" \"\n", false),
        ("[boards.1]\nname = \"aaaaaaaaaaaaaaaaaaaaaaaa\"\n", true),
        ("[boards.1]\nname = \"aaaaaaaaaaaaaaaaaaaaaaaaa\"\n", false),
        ("[boards.1.sensor]\nzero_counts = 1.0\n", false),
        ("[boards.1.sensor]\nzero_counts = 1.0\nkpa_per_count = 1\n", true),
        ("[boards.1.sensor]\nbits = 10\nzero_counts = 1.0\nkpa_per_count = 1\n", false),
        ("[sensor]\nzero_counts = 1.0\nkpa_per_count = 1\n", false),
        ("[display]\nunit = \"bar\"\n", true),
        ("[display]\nunit = \"Bar\"\n", false),
        ("[bus]\nboards = 0\n", false),
        ("[bus]\nboards = 1.5\n", false),
        ("[supply]\n", false),
        ("[chamber]\n", false),
        ("[chamber]\nradius_m = 0.02\n", false),
        ("[chamber]\nradius_m = 0.02\nlength_m = 0.2\n", true),
        ("[chamber]\nvolume_m3 = 0.02\n", true),
        ("[chamber]\nvolume_m3 = 0.02\noffset_m = 0.2\n", false),
        ("[chamber]\nvolume_m3 = 0.02\nlength_m = 0.2\nradius_m = 0.1\n", false),
        ("[boards.0.chamber]\nvolume_m3 = 0.02\n", true),
        ("[boards.0.chamber]\nradius_m = 0.02\n", false),
        ("[boards.0.channels.3.chamber]\nradius_m = 0.02\nlength_m = 0.2\n", true),
        ("[boards.0.channels.3.chamber]\nvolume_m3 = 0.02\nlength_m = 0.2\n", false),
        ("[valve]\ncritical_ratio = 0.3\n", true),
        ("[boards.0.valve]\ncritical_ratio = 0.3\n", false),
        ("[boards.0.channels.0.valve]\ncritical_ratio = 0.3\ndischarge_coefficient = 1\n", true),
        ("[boards.0.controller]\nrate_hz = 500\nkp = 5\nsaturation = 400\n", true),
        ("[boards.0.channels.0.controller]\nrate_hz = 500\nkp = 5\nsaturation = 400\n", false),
        ("[boards.0.supply]\npressure_kpa = 500\n", false),
    ] {
        let read = Rig::parse("rig.toml", text);
        let table: toml::Table = toml::from_str(text).unwrap();
        let document = serde_json::to_value(table).unwrap();
        let checked = schemas.validate(&document, index);
        assert_eq!(read.is_ok(), good, "reader: {text:?}: {read:?}");
        assert_eq!(checked.is_ok(), good, "schema: {text:?}");
    }
}

//! What the program prints is what the schemas in docs/ say.

use boon::{Compiler, Schemas};
use serde_json::Value;

pub const RUN: &str = include_str!("../../../../docs/run.schema.json");
pub const CHECK: &str = include_str!("../../../../docs/check.schema.json");

/// `object` must have every key of the schema, and no other: readers may meet more one day, but
/// docs/ has to tell of those there are.
#[track_caller]
pub fn conforms(object: &Value, schema: &str) {
    let mut schema: Value = serde_json::from_str(schema).unwrap();
    close(&mut schema);
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.add_resource("schema.json", schema).unwrap();
    let index = compiler.compile("schema.json", &mut schemas).unwrap();
    if let Err(error) = schemas.validate(object, index) {
        panic!("{error:#}\n{object:#}");
    }
}

fn close(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if map.contains_key("properties") {
                map.insert("additionalProperties".into(), false.into());
            }
            map.values_mut().for_each(close);
        }
        Value::Array(items) => items.iter_mut().for_each(close),
        _ => {}
    }
}

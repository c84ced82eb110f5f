//! Reading what the independent Python scripts in `tests/oracle` wrote.

use std::collections::HashMap;
use std::path::Path;

use pneudrive_model::model::column;

/// The columns of a CSV file by name; cells that are no numbers are NaN.
pub struct Table {
    columns: HashMap<String, Vec<f64>>,
}

impl Table {
    /// A file of `tests/oracle`.
    pub fn read(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle").join(name);
        let mut reader = csv::Reader::from_path(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let mut columns: HashMap<String, Vec<f64>> = HashMap::new();
        for record in reader.records() {
            for (name, cell) in names.iter().zip(record.unwrap().iter()) {
                columns.entry(name.clone()).or_default().push(cell.parse().unwrap_or(f64::NAN));
            }
        }
        Self { columns }
    }

    pub fn column(&self, name: &str) -> &[f64] {
        &self.columns[name]
    }

    /// The inputs in the layout of the rollouts. Separate valves are driven by the positive and the
    /// negative part of `u`.
    pub fn inputs(&self, separate: bool) -> Vec<f64> {
        let time = self.column("t_s");
        let mut table = Vec::with_capacity(time.len() * column::COUNT);
        for k in 0..time.len() {
            let u = self.column("u")[k];
            let mut row = [0.0; column::COUNT];
            row[column::TIME_S] = time[k];
            row[column::INTERVAL_S] = 0.01;
            (row[column::FILL], row[column::VENT]) =
                if separate { (u.max(0.0), (-u).max(0.0)) } else { (u, -u) };
            row[column::COMMAND_PA] = self.column("command_pa")[k];
            row[column::SUPPLY_PA] = self.column("supply_pa")[k];
            row[column::INVERSE_VOLUME_PER_M3] = 1.0 / self.column("volume_m3")[k];
            row[column::VOLUME_RATE_M3_S] = self.column("volume_rate_m3_s")[k];
            table.extend(row);
        }
        table
    }
}

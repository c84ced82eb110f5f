//! Pressure models of pneumatic chambers: fitting, comparison, diagnosis.

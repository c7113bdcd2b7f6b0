//! The checks of an experiment, as its JSON lists them.

use serde_json::Value;

/// The list `checks` of a summary; empty if it has none.
pub fn checks(summary: &Value) -> Vec<Value> {
    summary["checks"].as_array().cloned().unwrap_or_default()
}

/// The names of the checks that failed.
pub fn failures(checks: &[Value]) -> Vec<String> {
    let failed = checks.iter().filter(|check| check["passed"] != true);
    failed.filter_map(|check| check["name"].as_str().map(str::to_owned)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_that_failed_are_named() {
        let summary = serde_json::json!({ "checks": [
            { "name": "energy", "passed": true }, { "name": "overlap", "passed": false }
        ] });
        assert_eq!(failures(&checks(&summary)), ["overlap"]);
        assert!(checks(&Value::Null).is_empty());
    }
}

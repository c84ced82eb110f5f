//! Names of the node and its topics: expansion and remapping.

use ros2_client::{Name, NodeName};

/// A name that ROS does not allow.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{name:?} is no name for a {what}: {reason}")]
pub struct NameError {
    name: String,
    what: &'static str,
    reason: String,
}

/// The node's own name, and what to call topics instead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    namespace: String,
    node: String,
    remaps: Vec<(String, String)>,
}

impl Names {
    /// `remaps` may hold `__ns` and `__node`, as on the command line of any node; they win.
    pub fn new(namespace: &str, node: &str, remaps: &[(String, String)]) -> Result<Self, NameError> {
        let special =
            |key: &str| remaps.iter().rev().find(|(from, _)| from == key).map(|(_, to)| to.as_str());
        let namespace = special("__ns").unwrap_or(namespace);
        let node = special("__node").or(special("__name")).unwrap_or(node);
        let namespace = format!("/{}", namespace.trim_matches('/'));
        let names = Self { namespace, node: node.to_owned(), remaps: Vec::new() };
        names.node_name()?;
        let rules = remaps.iter().filter(|(from, _)| !from.starts_with("__"));
        let remaps = rules.map(|(from, to)| (names.expand(from), names.expand(to))).collect();
        Ok(Self { remaps, ..names })
    }

    /// The node's name as the library has it.
    pub fn node_name(&self) -> Result<NodeName, NameError> {
        NodeName::new(&self.namespace, &self.node).map_err(|error| NameError {
            name: format!("{} {}", self.namespace, self.node),
            what: "node",
            reason: error.to_string(),
        })
    }

    /// Namespace and name, as in `/arm/pneudrive`.
    pub fn full(&self) -> String {
        format!("{}/{}", self.namespace.trim_end_matches('/'), self.node)
    }

    /// A topic's full name after remapping. `~/` stands for the node's full name.
    pub fn topic(&self, name: &str) -> Result<Name, NameError> {
        let full = self.expand(name);
        let renamed = self.remaps.iter().find(|(from, _)| *from == full).map_or(&full, |(_, to)| to);
        Name::parse(renamed).map_err(|error| NameError {
            name: renamed.clone(),
            what: "topic",
            reason: error.to_string(),
        })
    }

    fn expand(&self, name: &str) -> String {
        match (name.strip_prefix("~/"), name.starts_with('/')) {
            (Some(rest), _) => format!("{}/{rest}", self.full()),
            (None, true) => name.to_owned(),
            (None, false) => format!("{}/{name}", self.namespace.trim_end_matches('/')),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(remaps: &[(&str, &str)]) -> Result<Names, NameError> {
        let remaps: Vec<_> = remaps.iter().map(|(from, to)| ((*from).to_owned(), (*to).to_owned())).collect();
        Names::new("/", "pneudrive", &remaps)
    }

    fn topic(names: &Names, name: &str) -> Name {
        names.topic(name).unwrap()
    }

    #[test]
    fn private_names_are_below_the_node() {
        let root = names(&[]).unwrap();
        assert_eq!(root.full(), "/pneudrive");
        assert_eq!(
            topic(&root, "~/joint_0/pressure_state"),
            Name::parse("/pneudrive/joint_0/pressure_state").unwrap()
        );
        let arm = names(&[("__ns", "/left/arm"), ("__node", "air")]).unwrap();
        assert_eq!(topic(&arm, "~/x"), Name::parse("/left/arm/air/x").unwrap());
        assert_eq!(topic(&arm, "/diagnostics"), Name::parse("/diagnostics").unwrap());
    }

    #[test]
    fn topics_can_be_remapped() {
        let remapped = names(&[("~/joint_0/pressure_state", "p0"), ("__ns", "arm")]).unwrap();
        assert_eq!(topic(&remapped, "~/joint_0/pressure_state"), Name::parse("/arm/p0").unwrap());
        assert_eq!(topic(&remapped, "~/joint_1/x"), Name::parse("/arm/pneudrive/joint_1/x").unwrap());
    }

    #[test]
    fn what_ros_does_not_allow_is_refused() {
        assert!(names(&[("__node", "0bad")]).is_err());
        assert!(names(&[("__ns", "/a b")]).is_err());
        assert!(names(&[("~/x", "/a//b")]).unwrap().topic("~/x").is_err());
    }
}

/// What a topic of ours carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    State,
    Command,
}

/// `{node}/joint_{n}/pressure_state` or `pressure_command`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    /// The node's full name, with its namespace.
    pub(super) node: String,
    pub(super) joint: u8,
    pub(super) quantity: Quantity,
}

impl Topic {
    /// `None` for topics of others.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let (rest, quantity) = name.rsplit_once('/')?;
        let quantity = match quantity {
            "pressure_state" => Quantity::State,
            "pressure_command" => Quantity::Command,
            _ => return None,
        };
        let (node, joint) = rest.rsplit_once('/')?;
        let joint = joint.strip_prefix("joint_")?.parse().ok()?;
        Some(Self { node: node.to_owned(), joint, quantity })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_the_node_and_of_others() {
        let topic = Topic::parse("/arm/pneudrive/joint_3/pressure_command");
        let expected = Topic { node: "/arm/pneudrive".into(), joint: 3, quantity: Quantity::Command };
        assert_eq!(topic, Some(expected));
        for foreign in
            ["/joint_states", "/x/joint_0/pressure", "/x/joint_y/pressure_state", "pressure_state", ""]
        {
            assert_eq!(Topic::parse(foreign), None, "{foreign}");
        }
    }
}

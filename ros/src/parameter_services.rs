//! The six services by which other nodes read, set and describe parameters.
//!
//! Ours and not the DDS library's, which has no descriptions, ranges or read-only parameters.

use crate::args::Settings;
use crate::descriptions;
use crate::failure::Failure;
use crate::parameters;
use crate::services::{offer, serve};
use futures::join;
use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse,
};
use ros2_client::service::Server;
use ros2_client::{Node, Parameter, ParameterValue};

/// The services.
pub struct ParameterServices {
    describe: Server<DescribeParametersRequest, DescribeParametersResponse>,
    get: Server<GetParametersRequest, GetParametersResponse>,
    types: Server<GetParameterTypesRequest, GetParameterTypesResponse>,
    list: Server<ListParametersRequest, ListParametersResponse>,
    set: Server<SetParametersRequest, SetParametersResponse>,
    set_atomically: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
    initial: parameters::Initial,
}

impl ParameterServices {
    /// Offers them.
    pub fn new(node: &mut Node, settings: &Settings) -> Result<Self, Failure> {
        let package = "rcl_interfaces";
        Ok(Self {
            describe: offer(node, settings, "~/describe_parameters", (package, "DescribeParameters"))?,
            get: offer(node, settings, "~/get_parameters", (package, "GetParameters"))?,
            types: offer(node, settings, "~/get_parameter_types", (package, "GetParameterTypes"))?,
            list: offer(node, settings, "~/list_parameters", (package, "ListParameters"))?,
            set: offer(node, settings, "~/set_parameters", (package, "SetParameters"))?,
            set_atomically: offer(
                node,
                settings,
                "~/set_parameters_atomically",
                (package, "SetParametersAtomically"),
            )?,
            initial: parameters::initial(settings),
        })
    }

    /// Answers until the node ends.
    pub async fn answer(&self, node: &Node) {
        let value = |name: &String| node.get_parameter(name).unwrap_or(ParameterValue::NotSet);
        join!(
            serve(&self.describe, |request| DescribeParametersResponse {
                values: request
                    .names
                    .iter()
                    .map(|name| descriptions::descriptor(name, &value(name)))
                    .collect()
            }),
            serve(&self.get, |request| GetParametersResponse {
                values: request.names.iter().map(|name| value(name).into()).collect()
            }),
            serve(&self.types, |request| GetParameterTypesResponse {
                values: request
                    .names
                    .iter()
                    .map(|name| ParameterValue::to_parameter_type_raw(&value(name)))
                    .collect()
            }),
            serve(&self.list, |request| ListParametersResponse {
                result: ListParametersResult {
                    names: below(node.list_parameters(), &request.prefixes),
                    prefixes: Vec::new()
                }
            }),
            serve(&self.set, |request| SetParametersResponse {
                results: request.parameter.into_iter().map(|one| self.set_all(node, vec![one])).collect()
            }),
            serve(&self.set_atomically, |request| SetParametersAtomicallyResponse {
                result: self.set_all(node, request.parameter)
            }),
        );
    }

    /// Sets all of these parameters, or none.
    fn set_all(&self, node: &Node, parameters: Vec<raw::Parameter>) -> raw::SetParametersResult {
        let parameters: Vec<_> = parameters.into_iter().map(Parameter::from).collect();
        let checked = parameters.iter().try_for_each(|Parameter { name, value }| {
            if !node.has_parameter(name) {
                return Err(format!("there is no parameter {name}"));
            }
            parameters::check(&self.initial, name, value)
        });
        let set = checked.and_then(|()| {
            parameters.into_iter().try_for_each(|Parameter { name, value }| {
                let value = parameters::of_its_type(&node.get_parameter(&name), value);
                node.set_parameter(&name, value)
            })
        });
        raw::SetParametersResult::from(set)
    }
}

/// Of these names those that are, or lie below, one of the prefixes; all of them without any.
fn below(names: Vec<String>, prefixes: &[String]) -> Vec<String> {
    let is_below = |name: &str, prefix: &String| {
        name.strip_prefix(prefix.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let wanted = |name: &String| prefixes.is_empty() || prefixes.iter().any(|prefix| is_below(name, prefix));
    names.into_iter().filter(wanted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prefix_is_a_whole_part_of_a_name() {
        let names = || ["max_kpa", "max_kpa.x", "max_kpas"].map(str::to_owned).to_vec();
        assert_eq!(below(names(), &[]), names());
        assert_eq!(below(names(), &["max_kpa".to_owned()]), ["max_kpa", "max_kpa.x"]);
    }
}

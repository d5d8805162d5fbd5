//! The OpenAPI document, generated from the handlers, and the role that each route requires.

use std::collections::BTreeMap;

use axum::http::Method;
use serde_json::Value;
use utoipa::OpenApi;
use utoipa::openapi::OpenApi as Document;

use super::access::role::Role;
use super::problem::{FieldError, ProblemBody};

/// Extension of an operation that names the required role.
const ROLE: &str = "x-required-role";

/// The parts of the document that do not come from routes.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "vibrissa",
        description = "Supervisor for fleets of robots with soft whisker arrays. Lengths in mm, pressures in MPa, strain in \
                       m/m, errors as ratios; times are RFC 3339 in UTC. Errors are RFC 9457 problem documents \
                       (application/problem+json).",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(ProblemBody, FieldError)),
    // Relative to the address of the document, which is below a path behind some proxies.
    servers((url = "."))
)]
struct Base;

/// The document without its routes.
#[must_use]
pub fn base() -> Document {
    Base::openapi()
}

pub(super) fn operations(
    item: &mut utoipa::openapi::PathItem,
) -> impl Iterator<Item = (Method, &mut utoipa::openapi::path::Operation)> {
    let of_methods = [
        (Method::GET, item.get.as_mut()),
        (Method::POST, item.post.as_mut()),
        (Method::PUT, item.put.as_mut()),
        (Method::DELETE, item.delete.as_mut()),
        (Method::PATCH, item.patch.as_mut()),
    ];
    of_methods.into_iter().filter_map(|(method, operation)| Some((method, operation?)))
}

/// The role that each method of each route requires.
#[derive(Debug, Default)]
pub struct Roles(BTreeMap<String, BTreeMap<String, Role>>);

/// The requirement for a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// The caller must have this role.
    Role(Role),
    /// The route does not declare the method.
    NoSuchMethod,
    /// The route is not in the document.
    Undeclared,
}

impl Roles {
    /// Reads the roles off the document. GET requires a viewer; every other method must declare its role.
    ///
    /// # Panics
    /// A route that changes something declares no role. This is a programming error and appears at every start.
    #[must_use]
    pub fn of(document: &mut Document) -> Self {
        let mut roles: BTreeMap<String, BTreeMap<String, Role>> = BTreeMap::new();
        for (path, item) in &mut document.paths.paths {
            for (method, operation) in operations(item) {
                let declared = operation.extensions.as_ref().and_then(|extensions| extensions.get(ROLE));
                let declared = declared.and_then(Value::as_str).and_then(Role::of_word);
                let role = match (declared, &method) {
                    (Some(role), _) => role,
                    (None, &Method::GET) => Role::Viewer,
                    (None, _) => panic!("{method} {path} does not declare x-required-role"),
                };
                let extensions = operation.extensions.get_or_insert_default();
                extensions.insert(ROLE.to_owned(), Value::from(role.word()));
                roles.entry(path.clone()).or_default().insert(method.to_string(), role);
            }
        }
        Self(roles)
    }

    /// The requirement for a method of a route.
    #[must_use]
    pub fn needed(&self, method: &Method, path: &str) -> Need {
        let Some(methods) = self.0.get(path) else { return Need::Undeclared };
        let method = if method == Method::HEAD { "GET" } else { method.as_str() };
        methods.get(method).map_or(Need::NoSuchMethod, |&role| Need::Role(role))
    }

    /// The methods that a route declares, for the header `Allow`.
    #[must_use]
    pub fn methods(&self, path: &str) -> Vec<&str> {
        let methods = self.0.get(path).into_iter().flat_map(BTreeMap::keys).map(String::as_str);
        methods.flat_map(|method| if method == "GET" { vec!["GET", "HEAD"] } else { vec![method] }).collect()
    }
}

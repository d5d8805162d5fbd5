//! Completes the OpenAPI document with what many operations share: security, problems, other formats of an answer.

use axum::http::Method;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use utoipa::openapi::path::Operation;
use utoipa::openapi::schema::{ArrayItems, Components};
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{Content, Header, OpenApi as Document, Ref, RefOr, Response, Schema};

use super::document::operations;
use super::problem::MEDIA_TYPE;

/// Name of the security scheme.
const TOKEN: &str = "token";
/// Beginnings of the names of generic schemas; the name of the items' schema follows.
const GENERIC: [&str; 2] = ["Page_", "Groups_"];

/// Completes the document. `is_open` says whether a request without a token is let in.
///
/// # Panics
/// A part below is no valid part of a document. This is a programming error and appears at every start.
pub(super) fn complete(document: &mut Document, is_open: bool) {
    let components = document.components.get_or_insert_default();
    let token = Http::builder().scheme(HttpAuthScheme::Bearer).description(Some(
        "A token of `vibrissa token create` (`vbr_...`), the token of `http.token_file`, or a JWT of the OpenID \
         provider. Not needed on loopback, unless the service has a token file or a provider.",
    ));
    components.add_security_scheme(TOKEN, SecurityScheme::Http(token.build()));
    name_items(components);
    let none = is_open.then(SecurityRequirement::default);
    document.security = Some(none.into_iter().chain([SecurityRequirement::new(TOKEN, [""; 0])]).collect());
    let problem: Response = part(json!({
        "description": "A problem (RFC 9457)",
        "content": { MEDIA_TYPE: { "schema": { "$ref": "#/components/schemas/Problem" } } },
    }));
    for item in document.paths.paths.values_mut() {
        for (method, operation) in operations(item) {
            add_formats(operation);
            let statuses: &[&str] = if method == Method::GET {
                &["400", "401", "403", "404", "422", "429", "500", "503", "504"]
            } else {
                &[
                    "400", "401", "403", "404", "408", "409", "412", "413", "415", "422", "428", "429", "500", "503",
                    "504",
                ]
            };
            for status in statuses {
                let response = RefOr::T(problem.clone());
                operation.responses.responses.entry((*status).to_owned()).or_insert(response);
            }
        }
    }
}

/// A part of the document from its JSON.
fn part<T: DeserializeOwned>(json: Value) -> T {
    serde_json::from_value(json).expect("a part of an OpenAPI document")
}

/// Refers to the schema of the items by its name in pages and groups, where the items' schema is written out. Otherwise
/// generated clients have one type for a whisker and another for a whisker of a page.
fn name_items(components: &mut Components) {
    let mut named = Vec::new();
    for (name, schema) in &mut components.schemas {
        let item = GENERIC.iter().find_map(|generic| name.strip_prefix(generic));
        let (Some(item), RefOr::T(Schema::Object(page))) = (item, schema) else { continue };
        let Some(RefOr::T(Schema::Array(items))) = page.properties.get_mut("items") else { continue };
        let reference = RefOr::Ref(Ref::from_schema_name(item));
        let replaced = std::mem::replace(&mut items.items, ArrayItems::RefOrSchema(Box::new(reference)));
        if let ArrayItems::RefOrSchema(schema) = replaced {
            named.push((item.to_owned(), *schema));
        }
    }
    for (name, schema) in named {
        components.schemas.entry(name).or_insert(schema);
    }
}

/// Adds the format CSV, in which clients may ask for a list.
fn add_formats(operation: &mut Operation) {
    let Some(RefOr::T(answer)) = operation.responses.responses.get_mut("200") else { return };
    if answer.content.get("application/json").is_some_and(|content| refers_to(content, "Page_")) {
        let text: Content = part(json!({ "schema": { "type": "string" } }));
        answer.content.insert("text/csv".to_owned(), RefOr::T(text));
        let link: Header = part(json!({
            "description": "Address of the next page, `<...>; rel=\"next\"`; missing after the last page",
            "schema": { "type": "string" },
        }));
        answer.headers.insert("Link".to_owned(), RefOr::T(link));
    }
}

/// Whether the schema of a content is a reference to a schema with that beginning of its name.
fn refers_to(content: &RefOr<Content>, beginning: &str) -> bool {
    let RefOr::T(Content { schema: Some(RefOr::Ref(schema)), .. }) = content else { return false };
    schema.ref_location.rsplit('/').next().is_some_and(|name| name.starts_with(beginning))
}

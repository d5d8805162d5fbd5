//! Headers that protect against pages of other sites: no framing, no content sniffing, no foreign scripts.

use vibrissa_tests::web::ask;

use crate::http_program::HttpProgram;

const PATHS: [(&str, u16); 10] = [
    ("/", 200),
    ("/console/main.js", 200),
    ("/console/nothing.js", 404),
    ("/docs", 404),
    ("/openapi.json", 200),
    ("/problems/not-found", 200),
    ("/livez", 200),
    ("/metrics", 200),
    ("/v1/whiskers", 200),
    ("/v1/nothing", 404),
];

#[tokio::test]
async fn regress_every_answer_has_the_headers_that_keep_browsers_from_mistakes() {
    let program = HttpProgram::start(&[]);
    for (path, status) in PATHS {
        let answer = ask(program.http, "GET", path, &[]).await.unwrap();
        assert_eq!(answer.status, status, "{path}: {}", answer.body);
        for (name, value) in [
            ("x-content-type-options", "nosniff"),
            ("x-frame-options", "DENY"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-opener-policy", "same-origin"),
            ("cross-origin-resource-policy", "same-origin"),
        ] {
            assert_eq!(answer.headers.get(name).map(String::as_str), Some(value), "{path}: {name}");
        }
        let policy = &answer.headers["content-security-policy"];
        assert!(policy.contains("frame-ancestors 'none'") && policy.contains("base-uri 'none'"), "{path}: {policy}");
        let runs_nothing = policy.starts_with("default-src 'none'");
        let has_scripts = path == "/" || path.starts_with("/console/main");
        assert!(runs_nothing != has_scripts, "{path}: {policy}");
        let scripts = policy.split(';').find(|part| part.trim().starts_with("script-src"));
        assert_eq!(scripts.map(str::trim), has_scripts.then_some("script-src 'self'"), "{path}: {policy}");
        let caching = &answer.headers["cache-control"];
        assert_eq!(caching, if has_scripts { "no-cache" } else { "no-store" }, "{path}");
    }
}

#[tokio::test]
async fn regress_answers_to_whoever_is_not_let_in_have_them_too() {
    let program = HttpProgram::start(&[]);
    for headers in
        [[("X-Forwarded-For", "192.0.2.1")], [("Authorization", "Bearer vbr_x_y")], [("Host", "evil.example")]]
    {
        let answer = ask(program.http, "GET", "/v1/whiskers", &headers).await.unwrap();
        assert!(matches!(answer.status, 401 | 403), "{headers:?}: {}", answer.status);
        assert_eq!(answer.headers["x-content-type-options"], "nosniff", "{headers:?}");
        assert!(answer.headers["content-security-policy"].contains("default-src 'none'"), "{headers:?}");
    }
}

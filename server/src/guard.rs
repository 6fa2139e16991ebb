//! What is refused before anything looks at it: requests whose addressee or end is in doubt, and those without the token.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use subtle::ConstantTimeEq;

use crate::failure::Failure;
use crate::service::{Service, Shared};

/// Where whoever watches over the server asks, who has no token.
const OPEN: [&str; 2] = ["/healthz", "/readyz"];

/// Lets a request through or refuses it.
pub(crate) async fn guard(State(service): State<Service>, request: Request, next: Next) -> Response {
    match check(&service, &request) {
        Ok(()) => next.run(request).await,
        Err(failure) => failure.into_response(),
    }
}

pub(crate) fn check(service: &Shared, request: &Request) -> Result<(), Failure> {
    check_host(request)?;
    // With a Content-Length beside it, two servers may take two different ends (RFC 9112, 6.3). The server below drops the
    // length before anybody sees it, so that bodies in chunks are refused altogether.
    if request.headers().contains_key(header::TRANSFER_ENCODING) {
        return Err(Failure::LengthRequired);
    }
    if let Some(token) = &service.token
        && !OPEN.iter().any(|open| request.uri().path().ends_with(open))
        && !shows(request.headers(), token)
    {
        return Err(Failure::Unauthorized);
    }
    Ok(())
}

/// RFC 9112, 3.2: exactly one Host in HTTP/1.1.
fn check_host(request: &Request) -> Result<(), Failure> {
    let hosts = request.headers().get_all(header::HOST).iter().count();
    if request.version() == Version::HTTP_11 && hosts != 1 || hosts > 1 {
        return Err(Failure::BadRequest(format!(
            "a request has one Host, this one has {hosts}"
        )));
    }
    Ok(())
}

/// Compared in a time that does not tell how much of it is right.
fn shows(headers: &HeaderMap, token: &str) -> bool {
    let shown = headers.get(header::AUTHORIZATION).map(|value| value.as_bytes());
    shown
        .and_then(|value| value.strip_prefix(b"Bearer "))
        .is_some_and(|shown| shown.ct_eq(token.as_bytes()).into())
}

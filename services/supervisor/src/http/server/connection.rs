//! One connection, from its first byte to its end.

use std::convert::Infallible;
use std::future::poll_fn;
use std::net::SocketAddr;
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::{Context, Poll};

use axum::body::{Body, HttpBody};
use axum::extract::connect_info::ConnectInfo;
use axum::{BoxError, Router};
use hyper::body::{Bytes, Frame, Incoming, SizeHint};
use hyper::server::conn::http1::Builder;
use hyper::service::{Service, service_fn};
use hyper::{Request, Response};
use hyper_util::rt::TokioIo;
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::{oneshot, watch};
use tokio::time::{Instant, sleep_until};

use super::progress::{Followed, IDLE_PATIENCE, Progress, Slow, UnderWay};
use super::registry::Admitted;

/// Bytes of a request's head at the most, and of what is read or written at once.
const BUFFER_BYTES_MAX: usize = 16 * 1024;

/// Serves a connection until it ends; tells if the server has closed it for being slow. Nothing is allocated for requests before
/// the first byte of one is there.
pub(super) async fn serve(
    stream: TcpStream,
    peer: SocketAddr,
    admitted: Admitted,
    router: Router,
    mut stop: watch::Receiver<bool>,
) -> Option<Slow> {
    let Admitted { place, mut displaced, .. } = admitted;
    let begin = Instant::now();
    tokio::select! {
        ready = stream.readable() => ready.ok()?,
        _ = &mut displaced => return None,
        _ = stop.wait_for(|&stop| stop) => return None,
        () = sleep_until(begin + IDLE_PATIENCE) => return Some(Slow::Idle),
    }
    let progress = Progress::new(place, begin);
    Box::pin(requests(stream, peer, progress, displaced, router, stop)).await
}

async fn requests(
    stream: TcpStream,
    peer: SocketAddr,
    progress: Arc<Progress>,
    mut displaced: oneshot::Receiver<()>,
    router: Router,
    mut stop: watch::Receiver<bool>,
) -> Option<Slow> {
    let service = service_fn({
        let progress = progress.clone();
        move |request| answer(request, peer, progress.request(), router.clone())
    });
    let followed = Followed { stream, progress: progress.clone() };
    let mut builder = Builder::new();
    // `Progress` has the times: hyper's own would also cut an answer that is taken slowly.
    builder.header_read_timeout(None).max_buf_size(BUFFER_BYTES_MAX);
    let mut connection = pin!(builder.serve_connection(TokioIo::new(followed), service));
    let mut stopped = pin!(stop.wait_for(|&stop| stop));
    let mut timer = pin!(sleep_until(Instant::now() + IDLE_PATIENCE));
    let mut is_stopping = false;
    poll_fn(|cx| {
        if !is_stopping && stopped.as_mut().poll(cx).is_ready() {
            is_stopping = true;
            if progress.is_waiting() {
                return Poll::Ready(None);
            }
            connection.as_mut().graceful_shutdown();
        }
        // A client that goes away in the middle of something is no news.
        if connection.as_mut().poll(cx).is_ready() || Pin::new(&mut displaced).poll(cx).is_ready() {
            return Poll::Ready(None);
        }
        let Some((deadline, slow)) = progress.deadline() else { return Poll::Pending };
        if timer.deadline() != deadline {
            timer.as_mut().reset(deadline);
        }
        timer.as_mut().poll(cx).map(|()| Some(slow))
    })
    .await
}

async fn answer(
    mut request: Request<Incoming>,
    peer: SocketAddr,
    under_way: UnderWay,
    router: Router,
) -> Result<Response<Answer>, Infallible> {
    request.extensions_mut().insert(ConnectInfo(peer));
    let response = TowerToHyperService::new(router).call(request).await?;
    Ok(response.map(|body| Answer { body, _under_way: under_way }))
}

/// The body of an answer, which is under way until its end.
struct Answer {
    body: Body,
    _under_way: UnderWay,
}

impl HttpBody for Answer {
    type Data = Bytes;
    type Error = BoxError;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, BoxError>>> {
        Pin::new(&mut self.body).poll_frame(cx).map_err(Into::into)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

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

/// Size limit of a request's head, and of one read or write, in bytes.
const BUFFER_BYTES_MAX: usize = 16 * 1024;

/// Serves a connection until it ends, and returns the reason if the server closed it as too slow. The connection has no
/// buffers while no byte of a request has arrived, because most open connections are idle.
pub(super) async fn serve(
    stream: TcpStream,
    peer: SocketAddr,
    admitted: Admitted,
    router: Router,
    mut stop: watch::Receiver<bool>,
) -> Option<Slow> {
    let Admitted { place, mut displaced, .. } = admitted;
    let progress = Progress::new(place, Instant::now());
    let mut followed = Followed::new(stream, progress.clone());
    loop {
        if followed.unread.is_empty() {
            let (deadline, slow) = progress.deadline()?;
            tokio::select! {
                ready = followed.stream.readable() => ready.ok()?,
                _ = &mut displaced => return None,
                _ = stop.wait_for(|&stop| stop) => return None,
                () = sleep_until(deadline) => return Some(slow),
            }
        }
        let end = Box::pin(requests(followed, peer, progress.clone(), &mut displaced, router.clone(), stop.clone()));
        match end.await {
            End::Answered(back) => followed = back,
            End::Closed(slow) => return slow,
        }
    }
}

/// Why a loop over requests ended.
enum End {
    /// All received requests are answered; the connection waits for more.
    Answered(Followed),
    /// The connection is closed; the reason if the server found it too slow.
    Closed(Option<Slow>),
}

async fn requests(
    followed: Followed,
    peer: SocketAddr,
    progress: Arc<Progress>,
    displaced: &mut oneshot::Receiver<()>,
    router: Router,
    mut stop: watch::Receiver<bool>,
) -> End {
    let service = service_fn({
        let progress = progress.clone();
        move |request: Request<Incoming>| {
            let under_way = progress.request(!request.body().is_end_stream());
            answer(request, peer, under_way, router.clone())
        }
    });
    let mut builder = Builder::new();
    // `Progress` sets the deadlines: hyper's own timeout would also cut an answer that the client reads slowly.
    builder.header_read_timeout(None).max_buf_size(BUFFER_BYTES_MAX);
    let mut connection = builder.serve_connection(TokioIo::new(followed), service);
    let mut stopped = pin!(stop.wait_for(|&stop| stop));
    let mut timer = pin!(sleep_until(Instant::now() + IDLE_PATIENCE));
    let mut is_stopping = false;
    let closed = poll_fn(|cx| {
        if !is_stopping && stopped.as_mut().poll(cx).is_ready() {
            is_stopping = true;
            if progress.is_waiting() {
                return Poll::Ready(Some(None));
            }
            Pin::new(&mut connection).graceful_shutdown();
        }
        // A client that disconnects in the middle of a request is not worth a log message.
        if Pin::new(&mut connection).poll(cx).is_ready() || Pin::new(&mut *displaced).poll(cx).is_ready() {
            return Poll::Ready(Some(None));
        }
        if progress.is_idle() {
            return Poll::Ready(None);
        }
        let Some((deadline, slow)) = progress.deadline() else { return Poll::Pending };
        if timer.deadline() != deadline {
            timer.as_mut().reset(deadline);
        }
        timer.as_mut().poll(cx).map(|()| Some(Some(slow)))
    })
    .await;
    match closed {
        Some(slow) => End::Closed(slow),
        None => {
            let parts = connection.into_parts();
            End::Answered(parts.io.into_inner().behind(&parts.read_buf))
        }
    }
}

async fn answer(
    mut request: Request<Incoming>,
    peer: SocketAddr,
    under_way: UnderWay,
    router: Router,
) -> Result<Response<ResponseBody>, Infallible> {
    request.extensions_mut().insert(ConnectInfo(peer));
    let response = TowerToHyperService::new(router).call(request).await?;
    Ok(response.map(|body| ResponseBody { body, _under_way: under_way }))
}

/// Body of an answer. The request counts as under way until the body is dropped.
struct ResponseBody {
    body: Body,
    _under_way: UnderWay,
}

impl HttpBody for ResponseBody {
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

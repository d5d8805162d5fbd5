#!/bin/bash
# The image's health check: succeeds if GET /readyz answers 200. Needs nothing but bash.
set -eu
# Beyond loopback only the listener for monitoring answers without a token.
listen=${VIBRISSA_HTTP_MONITORING_LISTEN:-$VIBRISSA_HTTP_LISTEN}
exec 3<>"/dev/tcp/127.0.0.1/${listen##*:}"
printf 'GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n' >&3
read -r -t 4 _ status _ <&3
[ "$status" = 200 ]

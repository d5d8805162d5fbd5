"""The stack of docker-compose.yml as a private Compose project."""

import json
import os
import signal
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path

from .engine import run
from .programs import PROJECT

# Stand-in for each image.
STAND_INS = {"eclipse-mosquitto": "mosquitto", "postgres": "postgres", "prom/prometheus": "prometheus", "grafana/grafana": "grafana"}
# Default time limit of waits, s.
PATIENCE_S = 180


def until(what, look, patience_s=PATIENCE_S):
    """Calls `look` until its result is true, and returns the result."""
    deadline = time.monotonic() + patience_s
    while True:
        found = look()
        if found:
            return found
        if time.monotonic() > deadline:
            raise AssertionError(f"timed out after {patience_s} s waiting for: {what}")
        time.sleep(0.2)


class Stack:
    def __init__(self, folder, name, images):
        self.folder, self.name, self.images = Path(folder), name, images
        self.file = self.folder / "docker-compose.json"
        self.resolved = None

    def prepare(self):
        """Resolves docker-compose.yml. Only images, the folder of the secrets and build arguments are replaced."""
        secrets = self.folder / "secrets"
        run(PROJECT / "deploy" / "make-secrets", secrets)
        text = run("docker-compose", "--file", PROJECT / "docker-compose.yml", "config", cwd=PROJECT)
        # The system's Python has the YAML reader, which docker-compose 1.29 depends on.
        reader = "import json, sys, yaml; json.dump(yaml.safe_load(sys.stdin), sys.stdout)"
        resolved = json.loads(run("/usr/bin/python3", "-c", reader, input=text))
        for service in resolved["services"].values():
            image = service["image"].rsplit(":", 1)[0]
            if image in STAND_INS:
                service["image"] = self.images.tag(STAND_INS[image])
            else:
                service["image"] = self.images.tag(f"built-{image}")
                if service["image"] not in self.images.made:
                    self.images.made.append(service["image"])
            if "build" in service:
                service["build"]["args"] = {"RUST_IMAGE": self.images.tag("rust"), "DEBIAN_IMAGE": self.images.tag("debian")}
        for name, secret in resolved["secrets"].items():
            secret["file"] = str(secrets / name)
        self.file.write_text(json.dumps(resolved, indent=1))
        self.resolved = resolved

    def compose(self, *arguments):
        return run("docker-compose", "--project-name", self.name, "--file", self.file, *arguments)

    def services(self):
        return sorted(self.resolved["services"])

    def container(self, service):
        return self.compose("ps", "-q", service).strip()

    def inspect(self, service):
        return json.loads(run("docker", "inspect", self.container(service)))[0]

    def execute(self, service, *command):
        return run("docker", "exec", self.container(service), *command)

    def is_ready(self, service):
        """Whether a supervisor is ready, according to its listener for monitoring."""
        command = ["docker", "exec", self.container(service), "vibrissa-readyz"]
        return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def logs(self, service):
        ended = subprocess.run(["docker", "logs", self.container(service)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return ended.stdout.decode(errors="replace")

    def kill(self, service):
        """Kills a service like a crash: the engine does not know that it was intended, and restarts it."""
        os.kill(self.inspect(service)["State"]["Pid"], signal.SIGKILL)

    def sql(self, query):
        """Runs a query as the superuser and returns its output."""
        return self.execute("postgres", "psql", "-X", "-U", "vibrissa", "-d", "vibrissa", "-Atc", query).strip()

    def http(self, port, path):
        """Status and body of a GET on this host's loopback; None if there is no answer."""
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=5) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as answer:
            return answer.code, answer.read().decode()
        except OSError:
            return None

    def volumes(self):
        return run("docker", "volume", "ls", "-q").split()

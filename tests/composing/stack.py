"""The stack of docker-compose.yml as a project of its own."""

import json
import os
import signal
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path

from .engine import run

PROJECT = Path(__file__).parent.parent.parent
# Which stand-in is for which image.
STAND_INS = {"eclipse-mosquitto": "mosquitto", "postgres": "postgres", "prom/prometheus": "prometheus", "grafana/grafana": "grafana"}
# How long one thing may take to come true, s.
PATIENCE_S = 180


def until(what, look, patience_s=PATIENCE_S):
    """What `look` gives, as soon as that is something."""
    deadline = time.monotonic() + patience_s
    while True:
        found = look()
        if found:
            return found
        if time.monotonic() > deadline:
            raise AssertionError(f"did not come true within {patience_s} s: {what}")
        time.sleep(0.2)


class Stack:
    def __init__(self, folder, name, images):
        self.folder, self.name, self.images = Path(folder), name, images
        self.file = self.folder / "docker-compose.json"
        self.resolved = None

    def prepare(self):
        """Resolves docker-compose.yml; other than there are only images, the folder of the secrets, and the arguments of builds."""
        secrets = self.folder / "secrets"
        run(PROJECT / "deploy" / "make-secrets", secrets)
        text = run("docker-compose", "--file", PROJECT / "docker-compose.yml", "config", cwd=PROJECT)
        # With the system's Python: it has the reader of YAML that docker-compose 1.29 brings.
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
        """Whether a supervisor says so; the image asks its listener for monitoring."""
        command = ["docker", "exec", self.container(service), "vibrissa-readyz"]
        return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def logs(self, service):
        ended = subprocess.run(["docker", "logs", self.container(service)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return ended.stdout.decode(errors="replace")

    def kill(self, service):
        """As a crash: the engine does not know that it was on purpose, and starts it again."""
        os.kill(self.inspect(service)["State"]["Pid"], signal.SIGKILL)

    def sql(self, query):
        """One row of the database, as the superuser."""
        return self.execute("postgres", "psql", "-X", "-U", "vibrissa", "-d", "vibrissa", "-Atc", query).strip()

    def http(self, port, path):
        """Status and body of GET on this host's loopback; none if nobody answers."""
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=5) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as answer:
            return answer.code, answer.read().decode()
        except OSError:
            return None

    def volumes(self):
        return run("docker", "volume", "ls", "-q").split()

"""Queries in PromQL, limited to the selected supervisors and, for metrics of fleets, to the selected fleets."""

from .grafana import promql


def of_all(name, *matchers):
    """A metric of a supervisor as a whole."""
    return f'{name}{{{",".join(("job=~" + quoted("$job"), "instance=~" + quoted("$instance")) + matchers)}}}'


def of_fleet(name, *matchers):
    """A metric of the selected fleets, of which each may be a pattern: `pipe` leaves it as it is."""
    return of_all(name, "fleet=~" + quoted("${fleet:pipe}"), *matchers)


def quoted(text):
    return f'"{text}"'


def rate(series):
    """Per second."""
    return f"rate({series}[$__rate_interval])"


def gained(series):
    """Increase in the dashboard's time."""
    return f"increase({series}[$__range])"


def lately(series):
    """Increase in the interval of rates."""
    return f"increase({series}[$__rate_interval])"


def total(expression, by=""):
    return f"sum by ({by}) ({expression})" if by else f"sum({expression})"


def per_second(name, by=""):
    """Rate of a counter of the selected fleets, per second."""
    return total(rate(of_fleet(name)), by)


def largest(expression, by=""):
    return f"max by ({by}) ({expression})" if by else f"max({expression})"


def least(expression, by=""):
    return f"min by ({by}) ({expression})" if by else f"min({expression})"


def quantile(share, of, name, *matchers, by=""):
    """A quantile of a histogram over the interval of rates; empty without new observations."""
    groups = ", ".join(filter(None, ("le", by)))
    return f"histogram_quantile({share}, {total(rate(of(name + '_bucket', *matchers)), groups)}) >= 0"


def mean(of, name, *matchers, by=""):
    """The mean of a histogram over the interval of rates; empty without new observations."""
    parts = [total(rate(of(name + end, *matchers)), by) for end in ("_sum", "_count")]
    return f"{parts[0]} / ({parts[1]} > 0)"


def buckets(of, name, *matchers):
    """Observations in each bucket, for a heat map."""
    return total(lately(of(name + "_bucket", *matchers)), "le")


def any_of(expression, *labels):
    """Series above 0; without any, a single 0 whose labels are "none"."""
    nothing = "vector(0)"
    for label in labels:
        nothing = f'label_replace({nothing}, "{label}", "none", "", "")'
    return f"{expression} > 0 or on () {nothing}"


def shares(of, name, *matchers, by=()):
    """The median and high quantiles of a histogram, as queries."""
    return [promql(quantile(share, of, name, *matchers), f"{100 * share:g} %") for share in by or (0.5, 0.9, 0.99)]

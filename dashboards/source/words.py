"""Words of the database and of metrics, with their colours."""

CASES = {
    "SELF_COMPENSATION": "self-compensation",
    "SHORTER_FOR_LONGER": "shorter for longer",
    "LONGER_FOR_SHORTER": "longer for shorter",
}

# Errors measured in the paper, averaged over contact ratios: in its case 1, which includes self-compensation, and in
# its case 2.
PAPER_CASE_1 = 0.20385
PAPER_CASE_2 = 0.3618

HEALTH = {
    "HEALTHY": "green",
    "LEARNING": "blue",
    "SUSPECTED": "yellow",
    "TRIMMED": "red",
    "ERODING": "orange",
    "SENSITIVITY_LOSS": "purple",
    "STALE": "dark-red",
    "LEAK": "dark-orange",
    "NONE": "transparent",
}


def is_case(case):
    return f'case="{case}"'

"""Which combinations of effect groups are refused, and why: (groups that are there, groups that are not, what is said)."""

REFUSED = [
    ({"release"}, {"capture"}, r"&release: needs &capture"),
    ({"recontact", "capture"}, set(), r"&recontact: excludes &capture"),
    ({"stiffening"}, {"rotation"}, r"&stiffening: needs &rotation"),
]


def reason(groups):
    """What must be said of a scene with these groups; None where it must run."""
    for there, absent, said in REFUSED:
        if there <= groups and not absent & groups:
            return said
    return None

"""How each misbehaviour of program.py must end: the sentence of its error, or that it hurts
nobody.
"""

ERRORS = {
    "crashes": r"signal 11 \(SIGSEGV\) and did not answer \(standard error: about to crash\)",
    "exits": r"ended with exit status 3 and did not answer",
    "half-a-line": r"exit status 0 and did not answer, after half a line '\{\"id\": \"\d+\", \"do'",
    "closes-its-output": "closed its standard output and did not answer",
    "takes-all-memory": r"GB of memory and was ended; expected at most 0\.3 GB",
    "prints": r"wrote 'step 1 of 100' as the answer .* messages to standard error",
    "answers-another": r"'\{\"id\": \"7000\", .* as the answer to request '\d+'; expected the id",
    "answers-without-id": r"wrote '\{\"done\": true\}' as the answer",
    "answers-everything": "as the answer to a request; expected",
    "answers-a-list": r"wrote '\[\"done\", \"\d+\"\]' as the answer",
    "answers-deep": r"wrote '\[\[\[\[",
    "answers-in-colour": r"wrote '.*red",
    "answers-without-end": "wrote a line of more than 65536 bytes to standard output",
    "messages-without-end": "wrote more than .* bytes to standard error during one request",
    "says-done-and-wrote-nothing": "wrote no trajectory.csv",
    "writes-a-huge-file": r"SIGXFSZ: a file grew too large",
    "fails": "failed: the solver diverged at t = 3",
    "done-is-false": r"wrote '\{\"id\": \"\d+\", \"done\": false\}' as the answer",
    "done-is-null": r"\"done\": null\}' as the answer",
    "done-is-a-word": r"\"done\": \"yes\"\}' as the answer",
    "done-is-one": r"\"done\": 1\}' as the answer",
    "refuses-without-a-word": r"\"unsupported\": true\}' as the answer",
    "fails-without-a-word": r"\"failed\": null\}' as the answer",
    "is-not-warm": r"\"warm\": false\}' as the answer",
    "leaves-the-answer-to-a-child": "ended with exit status 0 and did not answer",
    "kills-its-parent": "was terminated externally, together with its supervisor process",
    "takes-its-folder-away-and-ends": "ended with exit status 5 and did not answer",
    "answers-in-utf16": r"wrote '\{\?\"\?i\?d\?.*' as the answer to a request",
    "answers-in-no-text": r"wrote '\{\"id\": \"\d+\", .*' as the answer to a request",
    "answers-with-nul": r"\"done\": true\}\?' as the answer to a request",
    "answers-two-requests-in-a-line": r"true\} \{\"id\": \"\d+\", \"done\": true\}' as the answer",
    "says-one-word-twice": r"\"done\": false, \"done\": true\}' as the answer to a request",
    "counts-without-end": r"\"steps\": 9+ \.\.\.' as the answer to a request",
    "answers-by-no-number": "wrote 'NaN' as the answer to a request",
    "says-an-empty-line": "wrote '' as the answer to a request",
    "says-ready-again": r"wrote '\{\"ready\": true\}' as the answer to a request",
    "fails-in-commands-at-length": r"failed: : :error file=a::no / # #\[error\]no\?\[2J\?::error",
    "answers-into-a-pipe": "trajectory.csv is a link, a pipe, a device or a folder",
    "holds-its-answer": "trajectory.csv cannot be read: Resource temporarily unavailable",
    "lifts-its-limit": "trajectory.csv",
    "warms-up-for-ever": r"\"warm\": true\}' as the answer",
}
LATER = {
    "crashes-later": r"signal 6 \(SIGABRT\) and did not answer",
    "ends-after-each-answer": r"ended with exit status 0",
    "prints-after-its-answer": "wrote 'goodbye'",
    "hands-its-pipes-on": "ended with exit status 0",
    "starts-anew": r"wrote '\{\"ready\": true\}'",
    "closes-its-input": "does not read its standard input; expected one line read for each",
    "answers-the-next-request-too": r"wrote '\{\"id\": \"2\", \"done\": true\}' after its answer",
    "is-warm-too-late": r"wrote '\{\"id\": \"1\", \"warm\": true\}' after its answer",
    "answers-twice": r"wrote '\{\"id\": \"1\", \"done\": true\}'",
}
"""What goes wrong at the second request."""
SLOW = {
    "stops-itself": "was still running after 1 s and was ended",
    "warms-up-and-hangs": "was still running after 1 s and was ended",
    "answers-drop-by-drop-for-ever": r"was ended, after half a line '\{+'",
    "ends-its-line-with-a-carriage-return": r"after half a line '.*\"done\": true\}'",
}
"""What goes wrong when the time of the request is up."""
HARMLESS = (
    "takes-the-id-for-a-number",
    "writes-an-array",
    "talks-on-standard-error",
    "warms-up",
    "answers-in-more-words",
    "answers-byte-by-byte",
    "ends-its-lines-as-windows",
    "goes-and-takes-its-folder-away",
    "leaves-children-in-sessions",
    "floods-between-requests",
    "closes-its-errors",
    "takes-the-name-of-its-messages",
    "empties-its-request",
    "stays-for-ever",
)
"""Judged as the good program is."""
KEEPING = {
    "keeps-velocity": "asked after another request, and then in a fresh process, velocity",
    "keeps-stiffness": "asked after another request, and then in a fresh process, position",
    "answers-with-the-trajectory-before": "asked after another request, and then in a fresh",
    "remembers-on-disk": "asked after another request, and then in a fresh process, position",
    "refuses-later": r"it was not supported \(no springs on Saturdays\), and then it was answered",
}
"""What a process keeps from one request to the next."""
OTHERS = {
    *("hangs", "refuses", "draws-lots", "softens-after-a-small-mass"),
    *("takes-more-memory-each-time", "takes-the-folder-of-its-request-away"),
}
"""Those that need a test of their own."""

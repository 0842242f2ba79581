"""What holds for all tests."""

import signal

# What a shell starts in the background ignores Ctrl-C, and hands that on to every process it
# starts; those of the tests are to be interrupted.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

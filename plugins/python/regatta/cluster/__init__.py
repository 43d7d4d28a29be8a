"""The runs of ``regatta study`` on a cluster: ``regatta study --on ADDRESS`` starts ``python3 -m regatta.cluster ADDRESS``.

That program gets a line of JSON for each task on standard input, ``{"id", "job", "layout", "result"}`` with the paths of
files, and gives the task to a Dask scheduler (``tcp://`` or ``tls://``) or to Ray (``ray://``). It writes ``{"workers": N}``
once, and ``{"id", "failure"}`` for each task that has ended, after the file of its result. If no task can be done, it ends
with one line on standard error that says why. It ends when its input does, and stops the tasks that are under way.

A worker needs the wheel of the same version, and nothing else: a task is sent to it as the content of its files.
"""

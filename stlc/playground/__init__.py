"""stlc in a browser: missions checked while they are written, laid out, solved, shown.

`engine` answers the page's requests, in Pyodide or anywhere else; `build` makes the page.
"""

"""FreeCAD runs this at every start, with and without a window; there is nothing to register.

Documents find the proxies of their objects by module path, and everything else is imported when it is asked for.
"""

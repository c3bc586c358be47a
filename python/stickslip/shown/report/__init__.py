"""What a person and other programs get of a discovery: report.json, report.html, models and figures.

`stickslip.shown.report.write.write_report` writes them all; nothing is imported here, matplotlib is slow to load.
"""

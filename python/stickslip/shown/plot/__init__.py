"""Figures; SVG and PNG."""

"""Reports: tables, charts, HTML, Markdown and JUnit as functions of records."""

"""The effects that a model may have beside (2.1) and its friction law: one file an effect, facts beside formula."""

"""What stages read and write: stores, tables, the scratch store, and a stage's entry."""

"""What people look at: tables, pictures, records. The only place that imports matplotlib, and only when it draws."""

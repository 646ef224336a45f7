"""The standard library of IEC 61131-3: functions as one table, function blocks as IL text."""

"""`tendond bridge`: rigs for other middleware."""

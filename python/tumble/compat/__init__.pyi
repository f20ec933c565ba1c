"""What `import tumble.compat` offers, for type checkers and editors."""

from tumble.compat import allantools as allantools
from tumble.compat import imucal as imucal

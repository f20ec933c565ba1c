# TUMBLE_LIBPQ_INCLUDE: the folder of libpq-fe.h, which has the types of the functions that an archive on PostgreSQL loads with
# the library at run time. Nothing is linked with libpq.
find_path(TUMBLE_LIBPQ_INCLUDE libpq-fe.h PATH_SUFFIXES postgresql pgsql)
mark_as_advanced(TUMBLE_LIBPQ_INCLUDE)

#include "tumble/archive/database/postgres.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <libpq-fe.h>

#include <bit>
#include <charconv>
#include <cstring>

namespace tumble::database {

namespace {

/// The functions of libpq that are used, with the types that its header gives them: PostgreSQL manual, chapter "libpq".
struct Libpq {
  decltype(&PQconnectdb) connectdb;
  decltype(&PQstatus) status;
  decltype(&PQerrorMessage) error_message;
  decltype(&PQfinish) finish;
  decltype(&PQsetNoticeProcessor) set_notice_processor;
  decltype(&PQexec) exec;
  decltype(&PQprepare) prepare;
  decltype(&PQexecPrepared) exec_prepared;
  decltype(&PQresultStatus) result_status;
  decltype(&PQresultErrorField) result_error_field;
  decltype(&PQresultErrorMessage) result_error_message;
  decltype(&PQntuples) tuples;
  decltype(&PQnfields) fields;
  decltype(&PQftype) type;
  decltype(&PQgetvalue) value;
  decltype(&PQgetlength) length;
  decltype(&PQgetisnull) is_null;
  decltype(&PQcmdTuples) command_rows;
  decltype(&PQclear) clear;
};

constexpr int as_text = 0, as_bytes = 1;
/// Types of columns, by their number in the catalogue pg_type, which no header of a client has.
enum Type : Oid { type_bytea = 17, type_int8 = 20, type_int4 = 23, type_float8 = 701 };

template <typename Function>
void find(void* library, const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(library, name));
  if (!function) throw Refusal{Refusal::Kind::failed, fmt::format("libpq has no function {}", name)};
}

Libpq load_libpq() {
  void* const library = dlopen("libpq.so.5", RTLD_NOW | RTLD_LOCAL);
  if (!library)
    throw Refusal{
        Refusal::Kind::failed,
        "an archive on PostgreSQL needs the library libpq.so.5, which is not installed; the package is libpq5 "
        "(Debian, Ubuntu) or libpq (Fedora)"};
  Libpq pq{};
  find(library, "PQconnectdb", pq.connectdb);
  find(library, "PQstatus", pq.status);
  find(library, "PQerrorMessage", pq.error_message);
  find(library, "PQfinish", pq.finish);
  find(library, "PQsetNoticeProcessor", pq.set_notice_processor);
  find(library, "PQexec", pq.exec);
  find(library, "PQprepare", pq.prepare);
  find(library, "PQexecPrepared", pq.exec_prepared);
  find(library, "PQresultStatus", pq.result_status);
  find(library, "PQresultErrorField", pq.result_error_field);
  find(library, "PQresultErrorMessage", pq.result_error_message);
  find(library, "PQntuples", pq.tuples);
  find(library, "PQnfields", pq.fields);
  find(library, "PQftype", pq.type);
  find(library, "PQgetvalue", pq.value);
  find(library, "PQgetlength", pq.length);
  find(library, "PQgetisnull", pq.is_null);
  find(library, "PQcmdTuples", pq.command_rows);
  find(library, "PQclear", pq.clear);
  return pq;
}

const Libpq& libpq() {
  static const Libpq pq = load_libpq();
  return pq;
}

struct Clear {
  void operator()(PGresult* result) const { libpq().clear(result); }
};
using Result = std::unique_ptr<PGresult, Clear>;

/// Repeating helps after: unique_violation, serialization_failure, deadlock_detected.
bool is_conflict(std::string_view state) { return state == "23505" || state == "40001" || state == "40P01"; }

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& letter : text)
    if (letter == '\n') letter = ' ';
  return text;
}

Result checked(const PGconn* connection, PGresult* raw) {
  Result result(raw);
  const ExecStatusType status = result ? libpq().result_status(result.get()) : PGRES_FATAL_ERROR;
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return result;
  const char* const state = result ? libpq().result_error_field(result.get(), PG_DIAG_SQLSTATE) : nullptr;
  const std::string text = result ? libpq().result_error_message(result.get()) : libpq().error_message(connection);
  throw Refusal{state && is_conflict(state) ? Refusal::Kind::conflict : Refusal::Kind::failed, one_line(text)};
}

/// The bytes of a number in network order.
template <typename Word>
Word word_of(const char* bytes) {
  Word word = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i)
    word = static_cast<Word>(word << 8 | static_cast<unsigned char>(bytes[i]));
  return word;
}

Value cell_of(const PGresult* result, int row, int column, Oid type) {
  if (libpq().is_null(result, row, column)) return {};
  const char* const bytes = libpq().value(result, row, column);
  const auto size = static_cast<std::size_t>(libpq().length(result, row, column));
  switch (type) {
    case type_int8:
      return static_cast<std::int64_t>(word_of<std::uint64_t>(bytes));
    case type_int4:
      return std::int64_t{static_cast<std::int32_t>(word_of<std::uint32_t>(bytes))};
    case type_float8:
      return std::bit_cast<double>(word_of<std::uint64_t>(bytes));
    case type_bytea:
      return Bytes{std::string(bytes, size)};
    default:
      return std::string(bytes, size);
  }
}

/// Values as libpq takes them.
struct Sent {
  std::vector<std::string> texts;
  std::vector<const char*> pointers;
  std::vector<int> lengths, formats;

  explicit Sent(const Row& values)
      : texts(values.size()), pointers(values.size()), lengths(values.size()), formats(values.size(), as_text) {
    for (std::size_t i = 0; i < values.size(); ++i) add(i, values[i]);
  }
  void add(std::size_t i, const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) texts[i] = fmt::format("{}", *whole);
    if (const auto* real = std::get_if<double>(&value)) texts[i] = fmt::format("{}", *real);
    const auto* const text = std::get_if<std::string>(&value);
    const auto* const bytes = std::get_if<Bytes>(&value);
    const std::string& written = text ? *text : bytes ? bytes->data : texts[i];
    if (text && text->find('\0') != std::string::npos)
      throw Refusal{Refusal::Kind::failed, "a text has a character of value 0, which PostgreSQL cannot keep"};
    pointers[i] = std::holds_alternative<std::monostate>(value) ? nullptr : written.c_str();
    lengths[i] = static_cast<int>(written.size());
    formats[i] = bytes ? as_bytes : as_text;
  }
};

}  // namespace

void Postgres::Finish::operator()(PGconn* connection) const { libpq().finish(connection); }

Postgres::Postgres(const std::string& address) : connection_(libpq().connectdb(address.c_str())) {
  if (!connection_ || libpq().status(connection_.get()) != CONNECTION_OK)
    throw Refusal{Refusal::Kind::failed,
                  connection_ ? one_line(libpq().error_message(connection_.get())) : "no memory"};
  libpq().set_notice_processor(
      connection_.get(), [](void*, const char*) {}, nullptr);
  script("SET client_encoding TO 'UTF8'; SET synchronous_commit TO on");
}

const std::string& Postgres::prepared(const std::string& sql, const Row& values) {
  const auto known = names_.find(sql);
  if (known != names_.end()) return known->second;
  std::string name = fmt::format("s{}", names_.size());
  checked(connection_.get(), libpq().prepare(connection_.get(), name.c_str(), numbered_parameters(sql).c_str(),
                                             static_cast<int>(values.size()), nullptr));
  return names_.emplace(sql, std::move(name)).first->second;
}

void Postgres::rows(const std::string& sql, const Row& values, const RowSink& sink) {
  const std::string& name = prepared(sql, values);
  const Sent sent(values);
  const Result result =
      checked(connection_.get(),
              libpq().exec_prepared(connection_.get(), name.c_str(), static_cast<int>(values.size()),
                                    sent.pointers.data(), sent.lengths.data(), sent.formats.data(), as_bytes));
  const std::string_view written = libpq().command_rows(result.get());
  changed_ = 0;
  std::from_chars(written.data(), written.data() + written.size(), changed_);
  if (!sink) return;
  const int count = libpq().tuples(result.get()), columns = libpq().fields(result.get());
  std::vector<Oid> types;
  for (int i = 0; i < columns; ++i) types.push_back(libpq().type(result.get(), i));
  Row row(types.size());
  for (int r = 0; r < count; ++r) {
    for (int i = 0; i < columns; ++i)
      row[static_cast<std::size_t>(i)] = cell_of(result.get(), r, i, types[static_cast<std::size_t>(i)]);
    sink(row);
  }
}

void Postgres::script(const std::string& sql) {
  checked(connection_.get(), libpq().exec(connection_.get(), sql.c_str()));
}

std::string numbered_parameters(const std::string& sql) {
  std::string text;
  int number = 0;
  bool quoted = false;
  for (const char letter : sql) {
    if (letter == '\'') quoted = !quoted;
    text += letter == '?' && !quoted ? fmt::format("${}", ++number) : std::string(1, letter);
  }
  return text;
}

}  // namespace tumble::database

#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tumble/serve/event_feed.hpp"

namespace tumble {
/// A file that takes the body of a request. Its name is removed at the end: who keeps the file gives it another.
class BodyFile {
 public:
  /// A new file. Throws Error::bad_file.
  explicit BodyFile(const std::string& path);
  /// One that is open already, as this descriptor, which it closes.
  BodyFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  BodyFile(const BodyFile&) = delete;
  BodyFile& operator=(const BodyFile&) = delete;
  ~BodyFile();

  bool write(const char* bytes, std::size_t count);  ///< false: the disk is full, or fails
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int descriptor_ = -1;
};

/// A request as it came; nothing of it is trusted.
struct HttpRequest {
  std::string method, path;                                ///< path: decoded, without the query
  std::vector<std::pair<std::string, std::string>> query;  ///< decoded, in order
  std::map<std::string, std::string> headers;              ///< names in lower case
  std::string address;                                     ///< of who sent it
  std::chrono::steady_clock::time_point came;              ///< when it was whole
  std::string body;                                        ///< in memory
  std::uint64_t body_bytes = 0;
  std::shared_ptr<BodyFile> file;  ///< where the body is; null: in `body`
};

/// The first value of that name in the query; null for none.
const std::string* find_query(const HttpRequest& request, std::string_view name);

struct HttpResponse {
  unsigned status = 200;
  std::string type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
  /// Where set, what follows the body: called on the work pool until it returns false, each time with more bytes.
  std::function<bool(std::string& bytes)> more;
  /// Where set, the answer is these events behind number `seen`, without end.
  std::shared_ptr<EventFeed> events;
  std::uint64_t seen = 0;
  std::function<std::string(const std::string&)> said;  ///< where set, what is sent in place of these events
  /// Where set, whether events may still be sent: asked before each, and every two seconds; on the network thread.
  std::function<bool()> allowed;
};

/// Ways to an answer that do not wait for each other: each has threads of its own.
enum class Lane {
  usual,
  looks,    ///< at runs: a process that does not answer keeps a thread waiting
  sign_in,  ///< passwords: much memory and processor time each, one at a time
  begins,   ///< of runs: seconds
  orders,   ///< to runs
  stops,    ///< of runs: nothing else is ever in the way
  files,    ///< what bodies are written into: a disk may be slow
};

/// The lane of a request, and whose turn it takes there.
struct Way {
  Lane lane = Lane::usual;
  std::string line = {};  ///< empty: that of its party
};

/// Treatment of the body of a request whose head has come.
struct BodyPlan {
  std::optional<HttpResponse> refusal{};  ///< at once, without the body
  std::string party{};                    ///< who asks: shares of connections, memory and threads are by party
  std::uint64_t limit = 0;                ///< [bytes]; more is refused
  /// Where set, opens the file that takes the body, or says why not; on a thread of its lane, may block.
  std::function<std::optional<HttpResponse>(std::shared_ptr<BodyFile>& file)> open = {};
};

struct HttpHandler {
  std::function<BodyPlan(const HttpRequest& head)> admit;  ///< on the network thread: quick
  std::function<HttpResponse(const HttpRequest&)> answer;  ///< on a thread of its lane; may block
  std::function<Way(const HttpRequest&)> way = {};         ///< of a whole request, on the network thread: quick
  /// Changes a refusal that the server itself makes: words in the language of the page, headers.
  std::function<void(const HttpRequest&, HttpResponse&)> finish = {};
};

struct HttpOptions {
  std::string host = "127.0.0.1";
  unsigned port = 0;              ///< 0: any that is free
  std::string certificate, key;   ///< files in PEM form; empty: no TLS
  std::size_t workers = 3;        ///< threads of the usual lane; one party has one less
  std::size_t connections = 900;  ///< at once; beyond it one of the party that has most is closed
  double patience = 20.0;         ///< [s] for the head of a request, for 64 kB of a body, and for an idle connection
};

/// A server of HTTP/1.1: one thread for the network, and threads that answer, in lanes. No party can take what others
/// need: in each lane parties take turns, and each has a share of connections, streams of events, and memory for
/// bodies.
class HttpServer {
 public:
  /// Listens from now on. Throws Error::bad_input where it cannot, or where certificate and key do not serve.
  HttpServer(const HttpOptions& options, HttpHandler handler);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  unsigned port() const;
  /// Serves until stop(), or where `until_signal` until SIGINT or SIGTERM.
  void run(bool until_signal);
  void stop();  ///< from any thread

 private:
  struct Within;
  std::unique_ptr<Within> within_;
};

}  // namespace tumble

// A body that becomes a file: a disk that is slow keeps its upload waiting, and not the network thread.
#include <algorithm>
#include <utility>

#include "tumble/serve/http/connection.hpp"

namespace tumble::http {
namespace {

struct Stored {
  Shared c;
  std::optional<HttpResponse> refusal = std::nullopt;
};

/// Does some of it by a thread of the lane, and goes on.
template <class Work>
void store(Shared c, Work work, void (*next)(Shared)) {
  Server& server = c->server;
  const std::string party = c->party;
  const auto stored = std::make_shared<Stored>(Stored{std::move(c)});
  server.lanes.at(Lane::files).post(party, [stored, &server, work, next] {
    try {
      stored->refusal = work(*stored->c);
    } catch (const std::exception&) {
      stored->refusal = plain(503, "there is no memory for this body");
    }
    hand_back(server, stored, [next](Shared back, Stored& what) {
      what.refusal ? refuse(std::move(back), std::move(*what.refusal)) : next(std::move(back));
    });
  });
}

/// The file is closed and removed by the lane, too.
std::shared_ptr<BodyFile> released_by_lane(Server& server, std::shared_ptr<BodyFile> file) {
  BodyFile* const inner = file.get();
  return {inner, [&server, kept = std::move(file)](BodyFile*) mutable {
            if (!server.ending) try {
                server.lanes.at(Lane::files).post("ended", [file = kept] {});
              } catch (const std::bad_alloc&) {  // then here
              }
            kept.reset();
          }};
}

}  // namespace

void open_body_file(Shared c, void (*next)(Shared)) {
  store(
      std::move(c),
      [](Connection& connection) {
        std::shared_ptr<BodyFile> file;
        auto refusal = connection.plan.open(file);
        if (file) connection.request.file = released_by_lane(connection.server, std::move(file));
        return refusal;
      },
      next);
}

void write_body_file(Shared c, std::size_t count, void (*next)(Shared)) {
  store(
      std::move(c),
      [count](Connection& connection) {
        return connection.request.file->write(connection.piece.data(), count)
                   ? std::nullopt
                   : std::optional(plain(507, "the disk is full, or cannot be written"));
      },
      next);
}

}  // namespace tumble::http

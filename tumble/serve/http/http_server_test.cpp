#include "tumble/serve/http_server.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio.hpp>
#include <filesystem>
#include <future>
#include <thread>

#include "tumble/formats/testing/scratch_folder.hpp"

namespace tumble {
namespace {

using boost::asio::ip::tcp;

std::optional<HttpResponse> full() {
  HttpResponse response;
  response.status = 507;
  return response;
}

/// A server that takes bodies at /upload, each with what opens its file.
struct Uploads {
  std::function<std::optional<HttpResponse>(std::shared_ptr<BodyFile>&)> open;
  HttpServer server{{},
                    {.admit =
                         [this](const HttpRequest& head) {
                           BodyPlan plan{.party = head.path, .limit = 1 << 24};
                           if (head.path == "/upload") plan.open = open;
                           return plan;
                         },
                     .answer =
                         [](const HttpRequest& request) {
                           HttpResponse response;
                           response.body = std::to_string(request.body_bytes);
                           return response;
                         }}};
  std::thread network{[this] { server.run(false); }};

  ~Uploads() {
    server.stop();
    network.join();
  }
  /// What is answered to a body of so many bytes, of which so many are sent.
  std::string ask(const std::string& path, std::size_t length, std::size_t sent) const {
    boost::asio::io_context context;
    tcp::socket socket(context);
    socket.connect({boost::asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server.port())});
    const std::string head = "POST " + path +
                             " HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: " + std::to_string(length) +
                             "\r\n\r\n";
    boost::system::error_code code;
    boost::asio::write(socket, boost::asio::buffer(head + std::string(sent, 'x')), code);
    std::string answer;
    boost::asio::read(socket, boost::asio::dynamic_buffer(answer), code);
    return answer;
  }
  std::string quick() const { return ask("/other", 3, 3); }
};

TEST(HttpServer, ABodyBecomesAFile) {
  const ScratchFolder scratch;
  Uploads uploads;
  const auto path = (scratch.path / "part").string();
  uploads.open = [&](std::shared_ptr<BodyFile>& file) {
    file = std::make_shared<BodyFile>(path);
    return std::nullopt;
  };
  constexpr std::size_t size = 1'000'000;
  EXPECT_NE(uploads.ask("/upload", size, size).find("\r\n\r\n1000000"), std::string::npos);
  uploads.open = [](std::shared_ptr<BodyFile>&) { return full(); };
  EXPECT_NE(uploads.ask("/upload", size, 0).find("507"), std::string::npos);
  while (std::filesystem::exists(path)) std::this_thread::yield();  // it is removed when the answer is sent
}

/// The thread of the network goes on, whatever the disk does.
TEST(HttpServer, ADiskThatDoesNotAnswerKeepsItsUploadWaitingAlone) {
  Uploads uploads;
  std::promise<void> opening, opened;
  uploads.open = [&, go_on = opened.get_future().share()](std::shared_ptr<BodyFile>&) {
    opening.set_value();
    go_on.wait();
    return full();
  };
  auto upload = std::async(std::launch::async, [&] { return uploads.ask("/upload", 9, 9); });
  opening.get_future().wait();
  EXPECT_NE(uploads.quick().find("200 OK"), std::string::npos);
  opened.set_value();
  EXPECT_NE(upload.get().find("507"), std::string::npos);
}

TEST(HttpServer, ADiskThatIsSlowKeepsItsUploadWaitingAlone) {
  Uploads uploads;
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  uploads.open = [&](std::shared_ptr<BodyFile>& file) {
    file = std::make_shared<BodyFile>("/no/such/file", ends[1]);
    return std::nullopt;
  };
  constexpr std::size_t size = 1'000'000;  // more than a pipe takes that nobody reads
  auto upload = std::async(std::launch::async, [&] { return uploads.ask("/upload", size, size); });
  char byte = 0;
  ASSERT_EQ(read(ends[0], &byte, 1), 1);
  for (int i = 0; i < 20; ++i) EXPECT_NE(uploads.quick().find("200 OK"), std::string::npos);
  std::string rest(size - 1, '\0');
  for (std::size_t done = 0; done < rest.size();) {
    const auto count = read(ends[0], rest.data() + done, rest.size() - done);
    ASSERT_GT(count, 0);
    done += static_cast<std::size_t>(count);
  }
  EXPECT_NE(upload.get().find("\r\n\r\n1000000"), std::string::npos);
  close(ends[0]);
}

}  // namespace
}  // namespace tumble

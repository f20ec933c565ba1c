#include "tumble/station/link.hpp"

#include "tumble/station/link/loop.hpp"

namespace tumble {

struct Links::Inner {
  link::Loop loop;
};

Links::Links(std::function<double()> clock) : inner_(new Inner{link::Loop(std::move(clock))}) {}
Links::~Links() = default;

std::size_t Links::open(const LinkAddress& address, double timeout, double silence) {
  switch (address.kind) {
    case LinkAddress::Kind::tcp:
      return inner_->loop.open_tcp(address, timeout, silence);
    case LinkAddress::Kind::udp:
      return inner_->loop.open_udp(address, silence);
    case LinkAddress::Kind::serial:
      break;
  }
  return inner_->loop.open_serial(address, silence);
}

std::uint16_t Links::listen(std::uint16_t port, const std::string& host) { return inner_->loop.listen(port, host); }
Links::Terminal Links::open_terminal() { return inner_->loop.open_terminal(); }
void Links::send(std::size_t link, std::string_view bytes) { inner_->loop.send(link, bytes); }
std::size_t Links::unsent(std::size_t link) const { return inner_->loop.unsent(link); }
void Links::close(std::size_t link) { inner_->loop.close(link); }
bool Links::is_up(std::size_t link) const { return inner_->loop.is_up(link); }
std::string Links::peer(std::size_t link) const { return inner_->loop.peer(link); }
int Links::descriptor(std::size_t link) const { return inner_->loop.descriptor(link); }
std::vector<LinkEvent> Links::wait(double seconds) { return inner_->loop.wait(seconds); }
void Links::wake() { inner_->loop.wake(); }

}  // namespace tumble

// The server of gpvc view against those who may not ask, and those who ask too much.
#include "app/view/server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "app/view/guard.h"
#include "io/error.h"

namespace gpvc::view {
namespace {

using namespace std::chrono_literals;

TEST(ViewGuard, TokensAre32RandomHexadecimalDigits) {
  const std::string token = random_token();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_NE(token, random_token());
}

TEST(ViewGuard, PathsStayBelowTheToken) {
  EXPECT_EQ(below_token("/secret/", "secret"), "");
  EXPECT_EQ(below_token("/secret/pages/0", "secret"), "pages/0");
  for (const char* path : {"/", "/secret", "/secres/", "/secret2/", "secret/", "/secret/../x", "/secret/a/..",
                           "/secret/a/../../etc/passwd", "/secret/..\\x", "/secret/a\nb"})
    EXPECT_FALSE(below_token(path, "secret")) << path;
  EXPECT_TRUE(below_token("/secret/a..b", "secret"));
}

TEST(ViewGuard, OtherNamesOriginsAndSitesAreRefused) {
  EXPECT_FALSE(refusal({"127.0.0.1:80", "", ""}, 80));
  EXPECT_FALSE(refusal({"localhost:80", "http://localhost:80", "same-origin"}, 80));
  EXPECT_TRUE(refusal({"", "", ""}, 80));
  EXPECT_TRUE(refusal({"127.0.0.1:81", "", ""}, 80));
  EXPECT_TRUE(refusal({"evil.example:80", "", ""}, 80)) << "a name that resolves to this machine";
  EXPECT_TRUE(refusal({"127.0.0.1:80", "http://evil.example", ""}, 80));
  EXPECT_TRUE(refusal({"127.0.0.1:80", "http://localhost:80", ""}, 80)) << "the other name is another origin";
  EXPECT_TRUE(refusal({"127.0.0.1:80", "null", ""}, 80));
  EXPECT_TRUE(refusal({"127.0.0.1:80", "", "cross-site"}, 80));
}

// A server that answers with what it was asked, and clients of it.
class ViewServer : public testing::Test {
 protected:
  void start(ServerOptions options = {}) {
    server_.emplace([this](const Request& asked) { return answer(asked); }, options);
    thread_ = std::thread([this] { server_->run([this] { return ends_.load(); }); });
  }
  void TearDown() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Reply answer(const Request& asked) {
    ++answers_;
    if (asked.path == "bad") throw InputError("f\x01le", "", "is <b>bad</b>");
    return bytes_reply("text/plain", asked.path + "|" + asked.body);
  }
  std::string path(const std::string& below) const { return "/" + server_->token() + "/" + below; }
  httplib::Client client() const { return httplib::Client("127.0.0.1", server_->port()); }
  int status(const std::string& at, const httplib::Headers& headers = {}) const {
    auto answered = client().Get(at, headers);
    return answered ? answered->status : 0;
  }
  int connected() const {
    const int made = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(made, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0) return made;
    close(made);
    return -1;
  }
  // What comes before the other side closes.
  static std::string all_from(int from) {
    std::string bytes;
    char piece[4096];
    for (ssize_t got = 0; (got = recv(from, piece, sizeof piece, 0)) > 0;)
      bytes.append(piece, static_cast<std::size_t>(got));
    return bytes;
  }

  std::optional<Server> server_;
  std::thread thread_;
  std::atomic<bool> ends_ = false;
  std::atomic<int> answers_ = 0;
};

TEST_F(ViewServer, AnswersBelowItsTokenAlone) {
  start();
  auto answered = client().Get(path("page.json"));
  ASSERT_TRUE(answered);
  EXPECT_EQ(answered->status, 200);
  EXPECT_EQ(answered->body, "page.json|");
  EXPECT_NE(answered->get_header_value("Content-Security-Policy").find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(answered->get_header_value("Referrer-Policy"), "no-referrer");
  EXPECT_EQ(answered->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(answered->get_header_value("Access-Control-Allow-Origin"), "");
  const int before = answers_;
  EXPECT_EQ(status("/"), 404);
  EXPECT_EQ(status("/page.json"), 404);
  EXPECT_EQ(status("/" + std::string(32, '0') + "/page.json"), 404);
  EXPECT_EQ(status(path("../page.json")), 404);
  EXPECT_EQ(status(path("%2e%2e/%2e%2e/etc/passwd")), 404);
  EXPECT_EQ(status(path("a/%2e%2e%2fpasswd")), 404);
  EXPECT_EQ(answers_, before) << "nobody was asked";
}

TEST_F(ViewServer, RefusesOtherOriginsNamesAndForms) {
  start();
  EXPECT_EQ(status(path("x"), {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(status(path("x"), {{"Host", "evil.example"}}), 403);
  EXPECT_EQ(status(path("x"), {{"Sec-Fetch-Site", "cross-site"}}), 403);
  auto posted = client().Post(path("x"), "a=1", "application/x-www-form-urlencoded");
  ASSERT_TRUE(posted);
  EXPECT_EQ(posted->status, 415) << "a form of another page can send this without being asked";
  posted = client().Post(path("x"), "{}", "text/plain");
  ASSERT_TRUE(posted);
  EXPECT_EQ(posted->status, 415);
  EXPECT_EQ(client().Put(path("x"), "{}", "application/json")->status, 405);
  EXPECT_EQ(answers_, 0);
  EXPECT_EQ(client().Post(path("x"), "{}", "application/json")->body, "x|{}");
}

TEST_F(ViewServer, ARequestOfTenMegabytesIsRefused) {
  start();
  auto answered = client().Post(path("x"), std::string(10'000'000, 'a'), "application/json");
  EXPECT_TRUE(!answered || answered->status == 413);
  EXPECT_EQ(answers_, 0);
  EXPECT_EQ(status(path("x")), 200) << "it goes on";
}

TEST_F(ViewServer, ARequestIsNotHiddenInAnother) {
  start();
  const int to = connected();
  ASSERT_GE(to, 0);
  const std::string inner =
      "GET " + path("inner") + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server_->port()) + "\r\n\r\n";
  const std::string outer = "POST " + path("x") +
                            " HTTP/1.1\r\nHost: evil.example\r\nContent-Type: application/json\r\nContent-Length: " +
                            std::to_string(inner.size()) + "\r\n\r\n" + inner;
  ASSERT_EQ(send(to, outer.data(), outer.size(), 0), static_cast<ssize_t>(outer.size()));
  const std::string answered = all_from(to);
  close(to);
  EXPECT_EQ(answered.find(" 200 "), std::string::npos) << answered;
  EXPECT_EQ(answers_, 0);
}

TEST_F(ViewServer, SentencesHaveNoControlCharacters) {
  start();
  auto answered = client().Get(path("bad"));
  ASSERT_TRUE(answered);
  EXPECT_EQ(answered->status, 400);
  EXPECT_EQ(answered->body, "f\\x01le: is <b>bad</b>");
  EXPECT_EQ(answered->get_header_value("Content-Type"), "text/plain; charset=utf-8") << "markup shows as text";
}

TEST_F(ViewServer, SlowClientsDoNotKeepOthersWaiting) {
  ServerOptions options;
  options.threads = 2;
  options.to_ask = 500ms;
  start(options);
  std::vector<int> slow;
  for (int i = 0; i < 2; ++i) {
    slow.push_back(connected());
    ASSERT_EQ(send(slow.back(), "GET /", 5, 0), 5);
  }
  const auto begin = std::chrono::steady_clock::now();
  std::atomic<bool> done = false;
  // A byte now and then is no reason to wait longer.
  std::thread drips([&] {
    while (!done) {
      for (const int to : slow) static_cast<void>(send(to, "a", 1, MSG_NOSIGNAL));
      std::this_thread::sleep_for(50ms);
    }
  });
  EXPECT_EQ(status(path("x")), 200);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 4s);
  done = true;
  drips.join();
  for (const int to : slow) close(to);
}

TEST_F(ViewServer, AThousandConnectionsAreBounded) {
  ServerOptions options;
  options.idle = 500ms;
  start(options);
  std::vector<int> all;
  for (int i = 0; i < 1000; ++i)
    if (const int made = connected(); made >= 0) all.push_back(made);
  EXPECT_GT(all.size(), 100u);
  for (const int to : all) close(to);
  int answered = 0;
  for (int tries = 0; tries < 100 && answered != 200; ++tries) {
    answered = status(path("x"));
    std::this_thread::sleep_for(50ms);
  }
  EXPECT_EQ(answered, 200);
}

TEST_F(ViewServer, EventsReachPagesAndTheLastPageEndsIt) {
  ServerOptions options;
  options.without_page = 300ms;
  start(options);
  std::string heard;
  std::thread page([&] {
    client().Get(path("events"), [&](const char* data, std::size_t length) {
      heard.append(data, length);
      return heard.find("data: {\"a\":1}") == std::string::npos;
    });
  });
  while (server_->pages() == 0) std::this_thread::sleep_for(5ms);
  server_->tell("job", "{\"a\":1}");
  page.join();
  EXPECT_NE(heard.find("event: job\ndata: {\"a\":1}\n\n"), std::string::npos);
  thread_.join();  // which would not end without it
  EXPECT_EQ(server_->pages(), 0u);
}

TEST_F(ViewServer, APortThatIsTakenIsNamed) {
  start();
  ServerOptions options;
  options.port = server_->port();
  try {
    Server second([](const Request&) { return text_reply(200, ""); }, options);
    FAIL() << "both listen on one port";
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()), "port " + std::to_string(options.port) + " of 127.0.0.1 is not free");
  }
}

}  // namespace
}  // namespace gpvc::view

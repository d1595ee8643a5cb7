#!/bin/sh
# SPDX-License-Identifier: MIT
# How the client reaches a daemon on another machine: the source of its token and to whom it is sent, the
# certificates that it accepts, and its messages if that fails. This script has a small server, which notes
# the token of each request.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
cat >server.py <<'END'
import http.server, json, ssl, sys
status, location, files = int(sys.argv[1]), sys.argv[2], sys.argv[3:]
class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        print(self.headers.get("Authorization", "none"), file=sys.stderr, flush=True)
        body = {"jobs": []} if status == 200 else {"type": "about:blank", "status": status, "detail": "refused"}
        data = json.dumps(body).encode()
        self.send_response(status)
        if location:
            self.send_header("Location", location)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)
    do_POST = do_GET
    def log_message(self, *arguments):
        pass
class Server(http.server.ThreadingHTTPServer):
    def handle_error(self, *arguments):
        pass
server = Server(("127.0.0.1", 0), Handler)
if files:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*files)
    server.socket = context.wrap_socket(server.socket, server_side=True, do_handshake_on_connect=False)
print(server.server_port, flush=True)
server.serve_forever()
END
servers=
serve() { # NAME STATUS LOCATION [CERTIFICATE KEY]: starts a server; $port is its port, NAME.log has the tokens
    name=$1
    shift
    python3 server.py "$@" >"$name.port" 2>"$name.log" &
    servers="$servers $!"
    within test -s "$name.port"
    port=$(cat "$name.port")
}
trap 'kill $servers 2>/dev/null; clean_up' EXIT
sent() { # prints the token that the last request to the server `plain` had
    tail -n 1 plain.log
}
silent() { # NAME: nothing that the last command printed contains a token
    if grep -q secret stdout stderr; then
        not_ok "$1" "$(cat stdout stderr)"
    else
        ok "$1"
    fi
}

# Where the token comes from
serve plain 200 ''
export PENUMBRA_URL="http://127.0.0.1:$port"
list="$penumbra list --retry 0"
exits "without a token" 0 $list
expect "none is sent" "$(sent)" none
mkdir -p config/penumbra
file=$work/config/penumbra/token
echo secret-file >"$file"
chmod 600 "$file"
exits "with a token in the user's file" 0 $list
expect "it is sent" "$(sent)" "Bearer secret-file"
exits "with another one in the environment" 0 env PENUMBRA_TOKEN=secret-env $list
expect "that is sent" "$(sent)" "Bearer secret-env"
exits "with a third one as an option" 0 env PENUMBRA_TOKEN=secret-env $list --token secret-option
expect "that is sent" "$(sent)" "Bearer secret-option"
exits "with an empty one as an option" 0 $list --token ''
expect "none is sent" "$(sent)" none
mkdir -p home/.config/penumbra
cp config/penumbra/token home/.config/penumbra/token
exits "with a token in ~/.config" 0 env -u XDG_CONFIG_HOME HOME="$work/home" $list
expect "it is sent" "$(sent)" "Bearer secret-file"
expect "a token to this machine gives no warning" "$(cat stderr)" ""
requests=$(wc -l <plain.log)
for mode in 0644 0640 0604 0700; do
    chmod $mode "$file"
    exits "a file of mode $mode is refused" 2 $list
    prints "the error has file, mode and command" stderr "$file: has mode $mode, must have 0600 or less: chmod 600 $file"
    silent "and no token"
done
exits "the file does not matter if there is another token" 0 $list --token secret-option
chmod 400 "$file"
exits "a file of mode 0400" 0 $list
chmod 600 "$file"
printf 'secret-a\nsecret-b\n' >"$file"
exits "a file of two lines is refused" 2 $list
prints "the error has the file" stderr "$file: must be one line"
silent "and no token"
: >"$file"
exits "an empty file is refused" 2 $list
prints "the error has the file" stderr "$file: is empty"
rm "$file"
mkdir "$file"
exits "a folder is refused" 2 $list
rmdir "$file"
exits "a token with a line feed is refused" 2 $list --token "$(printf 'secret\nHost: x')"
silent "and not printed"
if [ "$(id -u)" = 0 ]; then
    echo secret-other >"$file"
    chmod 600 "$file"
    chown 65534 "$file"
    exits "a file of another user is refused" 2 $list
    prints "the error has the owner" stderr "$file: belongs to user 65534, must belong to user 0"
    rm "$file"
fi
expect "what is refused is not sent" "$(wc -l <plain.log)" $((requests + 2))

# A token for another server than that of --server, and a server that redirects
job=01890a5d-ac96-774b-bcce-b302099a8057
bench="$penumbra bench builtin:spheres --set width=8 --set height=6 --retry 0 --token secret"
exits "a report at another address than the daemon's" 3 env PENUMBRA_URL=http://localhost:1 $bench \
    --baseline "http://127.0.0.1:$port/v1/jobs/$job"
expect "is asked for without the token" "$(sent)" none
exits "a report of the daemon" 3 $bench --baseline "http://127.0.0.1:$port/v1/jobs/$job"
expect "is asked for with the token" "$(sent)" "Bearer secret"
before=$(wc -l <plain.log)
serve redirect 307 "http://127.0.0.1:$port/v1/jobs"
exits "a redirect is refused" 5 $list --server "http://127.0.0.1:$port" --token secret
prints "the error has the address" stderr "redirects to \"http://127.0.0.1:$(cat plain.port)/v1/jobs\""
expect "and the token is not sent there" "$(wc -l <plain.log)" "$before"

# Refused tokens
serve unauthorized 401 ''
none=http://127.0.0.1:$port
exits "401 without a token" 11 $list --server "$none"
prints "the error says where tokens come from" stderr "no token was sent: it comes from --token, PENUMBRA_TOKEN or $file"
exits "401 with a token" 11 $list --server "$none" --token secret-option
prints "the error says where it came from" stderr "the token came from --token or PENUMBRA_TOKEN"
silent "and does not have it"
(umask 077 && echo secret-file >"$file")
exits "401 with the file's token" 11 $list --server "$none" --json
prints "the error says where it came from" stderr "the token came from $file"
expect "so does the problem document" "$(jq -r .detail stdout)" "refused; the token came from $file"
silent "and does not have it"
rm "$file"
serve forbidden 403 ''
exits "403 with a token" 11 $list --server "http://127.0.0.1:$port" --token secret
prints "the error says where it came from" stderr "the token came from --token or PENUMBRA_TOKEN"

# A token that is not encrypted. The address is one that no machine has.
export http_proxy="http://127.0.0.1:$(cat plain.port)"
for far in http://192.0.2.1:9 http://127.example.invalid; do
    exits "a token over plain http to $far" 0 $list --server "$far" --token secret
    expect "gives a warning" "$(cat stderr)" "penumbra: warning: the token is sent unencrypted to $far; https keeps it secret"
done
exits "with --quiet" 0 "$penumbra" cancel x --quiet --retry 0 --server http://192.0.2.1:9 --token secret
expect "there is none" "$(grep -c warning stderr)" 0
exits "without a token" 0 $list --server http://192.0.2.1:9
expect "there is none" "$(cat stderr)" ""
unset http_proxy

# Certificates
if ! command -v openssl >/dev/null; then
    skip command-openssl "whose certificates the client accepts"
    finish
fi
key="-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes"
authority() { # NAME: makes a certificate authority
    openssl req -x509 $key -days 2 -subj "/CN=authority $1" -keyout "$1.key" -out "$1.pem" 2>>openssl.log
}
certificate() { # NAME HOSTS ARGUMENT…: makes a certificate that the authority `ca` has signed
    name=$1
    printf 'subjectAltName=%s\n' "$2" >extension
    shift 2
    openssl req $key -subj "/CN=$name" -keyout "$name.key" -out request 2>>openssl.log &&
        openssl x509 -req -in request -CA ca.pem -CAkey ca.key -CAcreateserial -extfile extension \
            -out "$name.pem" "$@" 2>>openssl.log
}
authority ca
authority other
certificate good DNS:localhost,IP:127.0.0.1 -days 2
certificate far DNS:render.example -days 2
certificate old DNS:localhost,IP:127.0.0.1 -days -1 ||
    certificate old DNS:localhost,IP:127.0.0.1 -not_before 20200101000000Z -not_after 20200102000000Z
serve good 200 '' good.pem good.key
good=$port
exits "a certificate of --ca" 0 $list --server "https://localhost:$good" --ca ca.pem --token secret
expect "gives no warning" "$(cat stderr)" ""
expect "and the token is sent" "$(tail -n 1 good.log)" "Bearer secret"
exits "by address, with PENUMBRA_CA" 0 env PENUMBRA_CA=ca.pem $list --server "https://127.0.0.1:$good/"
accepted=$(wc -l <good.log)
exits "without --ca" 5 "$penumbra" list --server "https://localhost:$good" --token secret
prints "the error says what to give" stderr "certificate; if the daemon is yours, give the authority that signed its certificate: --ca FILE"
exits "with another authority" 5 $list --server "https://localhost:$good" --ca other.pem
prints "the error says so" stderr "the authority in --ca or PENUMBRA_CA has not signed it"
exits "with a file that is not there" 2 $list --server "https://localhost:$good" --ca none.pem
prints "the error names it" stderr '--ca or PENUMBRA_CA: cannot read "none.pem": No such file'
exits "with a file without certificates" 5 $list --server "https://localhost:$good" --ca server.py
prints "the error says what it must be" stderr "--ca or PENUMBRA_CA must be a file of certificates in PEM"
serve far 200 '' far.pem far.key
exits "a certificate of another host" 5 $list --server "https://localhost:$port" --ca ca.pem --token secret
prints "the error says what to do" stderr "--server must have a host name or address that the certificate has"
serve old 200 '' old.pem old.key
exits "an expired certificate" 5 $list --server "https://localhost:$port" --ca ca.pem --token secret
prints "the error says so" stderr "certificate has expired; the daemon needs a certificate that is valid today"
exits "https to a port without TLS" 5 $list --server "https://127.0.0.1:$(cat plain.port)" --ca ca.pem
prints "the error says what to do" stderr "; if the daemon has no TLS, give --server http://"
exits "http to a port with TLS" 5 $list --server "http://localhost:$good"
prints "the error says what to do" stderr "; if the daemon has TLS, give --server https://"
expect "no server that is not trusted gets a request" "$(cat far.log old.log | wc -l) $(wc -l <good.log)" "0 $accepted"
finish

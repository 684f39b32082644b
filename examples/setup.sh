# Read by examples/run and tests/run. Looks for what Rust and Bevy need of the system, and on Linux
# installs what is missing where the package manager is known.
#
#   set_up            a Rust toolchain, a C compiler and linker, a Vulkan driver
#   set_up window     and the libraries that Bevy loads to open a window

set_up() {
    find_rust
    # macOS and Windows have their graphics driver, and Rust's installer asks for the linker.
    [ "$(uname -s)" = Linux ] || return 0
    find_package_manager
    look_for "$@"
    [ -n "$missing" ] || return 0
    say "Missing:$missing"
    if [ -n "$manager" ]; then
        install_packages || true
        look_for "$@"
        [ -n "$missing" ] || return 0
        say "Still missing:$missing"
    else
        say "Please install it: of the package managers, only apt-get, dnf and pacman are known here."
    fi
    can_link || stop "Nothing can be built without a C compiler and linker."
    say "Going on without."
}

find_rust() {
    rustup_bin=${CARGO_HOME:-${HOME-}/.cargo}/bin
    if ! have cargo; then
        PATH=$PATH:$rustup_bin # installed, but not yet in the path of this shell
    fi
    if ! have cargo || ! have rustc; then
        stop "cargo, Rust's build tool, was not found. How to get it: https://rustup.rs"
    fi
    version=$(rustc --version) || exit 1
    needed=$(sed -n 's/^rust-version = "1\.\([0-9]*\).*/\1/p' Cargo.toml)
    minor=${version#rustc 1.}
    minor=${minor%%.*}
    case $minor in
    '' | *[!0-9]*) return 0 ;; # no version that can be read here: cargo will judge
    esac
    [ "$minor" -ge "$needed" ] ||
        stop "Rust 1.$needed or newer is needed, this is $version. How to get it: rustup update stable"
}

find_package_manager() {
    for manager in apt-get dnf pacman; do
        if have "$manager"; then return 0; fi
    done
    manager=
}

# Sets `missing`, a line for each thing, and `packages`, which contain them.
look_for() {
    missing=
    packages=
    # Each line: the thing, then its packages for apt-get; dnf; pacman.
    can_link || note "a C compiler and linker (cc)" \
        "gcc libc6-dev" "gcc" "gcc"
    has_driver || note "a Vulkan driver" \
        "mesa-vulkan-drivers libvulkan1" "mesa-vulkan-drivers vulkan-loader" \
        "vulkan-swrast vulkan-icd-loader"
    [ "${1-}" = window ] || return 0
    look_for_library libxkbcommon-x11.so.0 libxkbcommon-x11-0 libxkbcommon-x11 libxkbcommon-x11
    look_for_library libX11.so.6 libx11-6 libX11 libx11
    look_for_library libX11-xcb.so.1 libx11-xcb1 libX11-xcb libx11
    look_for_library libXcursor.so.1 libxcursor1 libXcursor libxcursor
    look_for_library libXi.so.6 libxi6 libXi libxi
    look_for_library libXrandr.so.2 libxrandr2 libXrandr libxrandr
}

look_for_library() {
    has_library "$1" || note "$1, to open a window" "$2" "$3" "$4"
}

note() {
    missing="$missing
  $1"
    case $manager in
    apt-get) packages="$packages $2" ;;
    dnf) packages="$packages $3" ;;
    pacman) packages="$packages $4" ;;
    esac
}

# With a header: the C library's development files are a package of their own.
can_link() {
    printf '#include <string.h>\nint main(void) { return 0; }\n' |
        cc -x c -o /dev/null - >/dev/null 2>&1
}

# The loader and a driver that can draw here: one in software always can, the others need a device.
has_driver() {
    has_library libvulkan.so.1 || return 1
    manifests=$(driver_manifests)
    case $manifests in
    *lvp_icd* | *swiftshader*) return 0 ;;
    '') return 1 ;;
    esac
    for device in /dev/dri/renderD* /dev/nvidiactl /dev/dxg; do
        if [ -e "$device" ]; then return 0; fi
    done
    return 1
}

# The manifests that the Vulkan loader reads, less those of 32-bit drivers.
driver_manifests() {
    given=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES-}}
    config=${XDG_CONFIG_HOME:-${HOME-}/.config}:${XDG_CONFIG_DIRS:-/etc/xdg}:/etc
    data=${XDG_DATA_HOME:-${HOME-}/.local/share}:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}
    if [ -n "$given" ]; then
        lines "$given"
    else
        lines "$config:$data" | while read -r folder; do
            printf '%s\n' "$folder"/vulkan/icd.d/*.json
        done
    fi | while read -r manifest; do
        case $manifest in
        *.i[36]86.json) ;;
        *) [ ! -r "$manifest" ] || printf '%s\n' "$manifest" ;;
        esac
    done
}

has_library() {
    known=$(ldconfig -p 2>/dev/null || /sbin/ldconfig -p 2>/dev/null || true)
    case $known in
    *"$1 "*) return 0 ;;
    esac
    lines "${LD_LIBRARY_PATH-}" | while read -r folder; do
        [ ! -e "$folder/$1" ] || echo found
    done | grep -q found
}

install_packages() {
    # A package that holds two of the things is named once.
    # shellcheck disable=SC2046,SC2086 # the words of a list
    set -- $(printf '%s\n' $packages | sort -u)
    case $manager in
    apt-get)
        as_root apt-get update || true # one stale source of many is no reason to stop
        as_root env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y --no-install-recommends "$@"
        ;;
    dnf) as_root dnf install -y "$@" ;;
    pacman)
        # Without a list of packages yet, as in a fresh container, the system is brought up to date
        # with it: pacman allows no half-way update.
        if [ -e /var/lib/pacman/sync/core.db ]; then
            as_root pacman -S --needed --noconfirm "$@"
        else
            as_root pacman -Syu --needed --noconfirm "$@"
        fi
        ;;
    esac
}

# Prints the line and runs it.
as_root() {
    if [ "$(id -u)" -ne 0 ]; then
        if ! have sudo; then
            say "As root, please run: $*"
            return 1
        fi
        set -- sudo "$@"
    fi
    say "+ $*"
    "$@"
}

lines() {
    printf '%s\n' "$1" | tr : '\n'
}

have() {
    command -v "$1" >/dev/null 2>&1
}

say() {
    printf '%s\n' "$*" >&2
}

stop() {
    say "$@"
    exit 1
}

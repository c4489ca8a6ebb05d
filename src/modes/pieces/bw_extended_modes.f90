module bw_extended_modes
  !! Modes that binary64 does not tell apart or does not find, in binary128.
  !!
  !! The count of modes (bw_extended_stiffness) encloses mode k alone, and inverse iteration goes to it. Modes so close that
  !! binary128 does not tell them apart are one cluster: any orthonormal motions that span it are its modes. Where a piece is
  !! next to a clamped mode of its own the joints hardly move: it is cut in parts.
  use bw_double_double, only: dd, to_dd, to_quad, operator(+), operator(-), operator(*)
  use bw_extended_ends, only: extended_ends
  use bw_extended_residual, only: find_drive
  use bw_extended_stiffness, only: amplitudes_of, extended_stiffness, find_stiffness, move_joints, size_stiffness, stiffness_of
  use bw_kinds, only: dp, qp
  use bw_mode_probe, only: mode_probe, piece_system, probe_for, set_frequency, system_of, weigh
  use bw_piece_beam, only: cut_all, joint_position, piece_beam
  use bw_piece_overlap, only: mass_product, piece_modes
  implicit none (type, external)
  private
  public :: find_extended, find_resting, take

  integer, parameter :: cuts = 3                   !! ways to cut the pieces: in 1, 2 and 3 parts
  real(qp), parameter :: regular_enough = 1.0e-4_qp
  real(dp), parameter :: cluster_width = 1.0e-15_dp    !! of λ
  real(dp), parameter :: count_error = 1.0e-17_dp  !! of λ: where a count may be off, two pivots in a row nearly vanishing
  real(dp), parameter :: beside = 1.0e-15_dp       !! distance from a cluster at which its motions are found, of λ
  real(dp), parameter :: settled = 1.0e-28_dp      !! a step, of λ
  real(dp), parameter :: rounding = 1.0e-29_dp     !! of stiffness, some hundred units
  integer, parameter :: most_stays = 3             !! steps that do not get smaller: they are rounding
  integer, parameter :: most_steps = 400

  type :: divided_beam
    type(piece_system) :: system
    type(mode_probe) :: probe
    type(extended_stiffness) :: stiffness
  end type divided_beam

  type, public :: extended_search
    type(divided_beam), allocatable :: divided(:)  !! (cuts)
    integer :: parts = 1                           !! of each piece in the division that serves at this frequency
    real(qp), allocatable :: force(:, :)           !! that drives the inverse iteration, (2, 0:n·parts)
    real(dp) :: error = 0.0_dp                     !! of λ by rounding of stiffness
    type(dd) :: low, high                          !! frequencies on both sides of the mode
    integer :: below_low = 0, below_high = 0       !! modes below them
    integer :: first = 0, last = -1                !! numbers of the modes of the last cluster
    type(piece_modes) :: modes                     !! these
  end type extended_search

contains

  subroutine find_extended(search, beam, k, guess, distance, found)
    !! Mode k, and with it its cluster.
    type(extended_search), intent(inout) :: search
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: k
    type(dd), intent(in) :: guess                  !! about its λ
    real(dp), intent(in) :: distance               !! to the next, about
    logical, intent(out) :: found
    type(dd) :: x, next
    real(dp) :: correction, before
    integer :: i, stays
    logical :: alone, inside, gains
    stays = 0
    call open_search(search, beam)
    call enclose(search, k, guess, distance, found)
    if (.not. found) return
    x = guess
    before = huge(before)
    do i = 1, most_steps
      alone = search%below_low == k - 1 .and. search%below_high == k
      if (.not. alone) then
        if (gap(search%high, search%low) < cluster_width*abs(search%high%hi)) exit
        x = middle(search)
        call step_to(search, k, x)
        before = huge(before)
        cycle
      end if
      call step_to(search, k, x)
      if (before == huge(before)) call start(search, 1)
      call improve(search, correction)
      next = x + correction
      inside = min(gap(next, search%low), gap(search%high, next)) > -max(count_error*abs(x%hi), search%error)
      gains = abs(correction) < 0.5_dp*before
      if ((inside .and. abs(correction) < settled*abs(x%hi)) .or. &
          (stays > most_stays .and. abs(correction) < search%error)) then
        call keep_mode(search, k, next)
        return
      end if
      if (.not. (inside .and. gains)) stays = stays + 1
      x = next
      if (.not. inside .or. (mod(stays, 2) == 0 .and. .not. gains)) x = middle(search)
      before = abs(correction)
    end do
    found = i <= most_steps
    if (found) call find_cluster(search, search%below_low + 1, search%below_high, middle(search))
  end subroutine find_extended

  pure subroutine find_resting(search, beam, first, last)
    !! Modes of which it is known that λ = 0: the beam moves as a whole, or turns about its centre of mass or what holds it.
    type(extended_search), intent(inout) :: search
    type(piece_beam), intent(in) :: beam
    integer, intent(in) :: first, last             !! their numbers
    integer :: i, n
    call open_search(search, beam)
    call count_at(search, dd(), n)
    call open_cluster(search, first, last, dd())
    associate (motion => search%divided(search%parts)%stiffness%motion, divided => search%divided(search%parts)%system%beam)
      if (moves_freely(beam)) then
        motion(1, :) = 1.0_qp
        motion(2, :) = 0.0_qp
        call keep(search, 1)
        if (first == last) return
      end if
      motion(2, :) = 1.0_qp
      do i = 0, ubound(motion, 2)
        motion(1, i) = to_quad(joint_position(divided, i)) - pivot_of(beam)
      end do
      call keep(search, last - first + 1)
    end associate
  end subroutine find_resting

  pure logical function moves_freely(beam)
    !! Nothing holds its deflection.
    type(piece_beam), intent(in) :: beam
    moves_freely = .not. (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp &
                          .or. any(beam%joint%stiffness%hi > 0.0_dp))
  end function moves_freely

  pure real(qp) function pivot_of(beam) result(pivot)
    !! Where a beam that turns freely does not move: where it is held, else its centre of mass.
    type(piece_beam), intent(in) :: beam
    real(qp) :: outer, mass
    integer :: i
    pivot = 0.0_qp
    if (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp) return
    mass = 0.0_qp
    do i = 1, size(beam%piece)
      outer = to_quad(joint_position(beam, i))
      associate (own => to_quad(beam%piece(i)%mass*beam%piece(i)%length), body => to_quad(beam%joint(i)%mass))
        pivot = pivot + own*(outer - 0.5_qp*to_quad(beam%piece(i)%length)) + body*outer
        mass = mass + own + body
      end associate
    end do
    pivot = pivot/mass
    do i = 1, size(beam%piece)
      if (beam%joint(i)%stiffness%hi > 0.0_dp) pivot = to_quad(joint_position(beam, i))
    end do
  end function pivot_of

  pure subroutine open_search(search, beam)
    type(extended_search), intent(inout) :: search
    type(piece_beam), intent(in) :: beam
    integer :: c, i
    if (allocated(search%divided)) return
    allocate (search%divided(cuts))
    do c = 1, cuts
      associate (divided => search%divided(c))
        divided%system = system_of(cut_all(beam, [(c, i=1, size(beam%piece))]))
        divided%probe = probe_for(divided%system)
        call size_stiffness(c*size(beam%piece), divided%stiffness)
      end associate
    end do
  end subroutine open_search

  pure subroutine enclose(search, k, guess, distance, found)
    !! Count on both sides, further away until mode k is between.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: guess
    real(dp), intent(in) :: distance
    logical, intent(out) :: found
    integer, parameter :: most = 100
    type(dd) :: edge
    real(dp) :: margin
    integer :: i, n
    search%below_low = -1
    search%below_high = -1
    margin = distance
    do i = 1, most
      found = search%below_low >= 0 .and. search%below_high >= 0
      if (found) return
      if (search%below_low < 0) then
        edge = guess + (-margin)
        if (guess%hi > 0.0_dp) edge = guess*(1.0_dp/(1.0_dp + margin/guess%hi))    ! above 0
        call count_at(search, edge, n)
        if (n < k) call set_low(search, edge, n)
        if (n >= k) call set_high(search, edge, n)
      end if
      if (search%below_high < 0) then
        edge = guess + margin
        call count_at(search, edge, n)
        if (n >= k) call set_high(search, edge, n)
        if (n < k) call set_low(search, edge, n)
      end if
      margin = 2.0_dp*margin
    end do
  end subroutine enclose

  pure subroutine set_low(search, x, below)
    type(extended_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(in) :: below
    search%low = x
    search%below_low = below
  end subroutine set_low

  pure subroutine set_high(search, x, below)
    type(extended_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(in) :: below
    search%high = x
    search%below_high = below
  end subroutine set_high

  pure subroutine step_to(search, k, x)
    !! Set up a frequency; its count encloses mode k more closely.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: x
    integer :: n
    call count_at(search, x, n)
    if (n < k .and. gap(x, search%low) > 0.0_dp) call set_low(search, x, n)
    if (n >= k .and. gap(search%high, x) > 0.0_dp) call set_high(search, x, n)
  end subroutine step_to

  pure subroutine count_at(search, x, n)
    !! Set up a frequency in the division that serves, and count the modes below.
    type(extended_search), intent(inout) :: search
    type(dd), intent(in) :: x
    integer, intent(out) :: n
    real(qp) :: best
    integer :: c
    best = -1.0_qp
    do c = 1, cuts
      associate (divided => search%divided(c))
        call set_frequency(divided%system, x, divided%probe)
        call find_stiffness(divided%system, divided%probe%frequency, divided%stiffness)
        if (divided%stiffness%regular > best) then
          best = divided%stiffness%regular
          search%parts = c
        end if
      end associate
      if (best > regular_enough) exit
    end do
    n = search%divided(search%parts)%stiffness%below
  end subroutine count_at

  pure subroutine start(search, number)
    !! Forces that excite every mode, one set of many: bodies are driven as much as they weigh.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: number
    integer :: i, j
    associate (probe => search%divided(search%parts)%probe)
      if (allocated(search%force)) deallocate (search%force)
      allocate (search%force(2, 0:ubound(probe%push, 2)))
      do i = 0, ubound(probe%push, 2)
        do j = 1, 2
          search%force(j, i) = sin(real(1 + 7*number*(2*i + j)**2, dp))*probe%push(j, i)
        end do
      end do
    end associate
  end subroutine start

  pure subroutine improve(search, correction)
    !! One inverse iteration, and by how much the frequency of its mode differs.
    type(extended_search), intent(inout) :: search
    real(dp), intent(out) :: correction
    real(qp) :: largest
    integer :: i
    associate (divided => search%divided(search%parts))
      associate (probe => divided%probe, motion => divided%stiffness%motion, unit => divided%probe%unit)
        if (size(search%force, 2) /= size(motion, 2)) call start(search, 1)
        call hold_root(divided%system, search%force)
        call move_joints(search%force, unit, divided%stiffness)
        largest = max(maxval(abs(motion)/unit(1:2, :)), real(tiny(1.0_dp), qp))
        motion = motion/largest
        search%force = search%force/largest
        probe%drive = 0.0_dp
        probe%drive(2, :, :) = real(search%force/unit(4:3:-1, :), dp)
        do i = 1, size(divided%system%piece)
          probe%amplitude(:, i) = real(amplitudes_of(divided%stiffness, i, i, divided%stiffness%outer(:, :, i)), dp)
        end do
        call weigh(divided%system, probe)
        correction = real(sum(motion*search%force), dp)/probe%mass
        search%error = rounding*real(stiffness_of(divided%stiffness), dp)/probe%mass
        search%force = motion*(probe%push/unit(1:2, :))
      end associate
    end associate
  end subroutine improve

  pure subroutine hold_root(system, force)
    !! What is held takes no force.
    type(piece_system), intent(in) :: system
    real(qp), intent(inout) :: force(:, 0:)
    if (system%beam%root%holds_deflection) force(1, 0) = 0.0_qp
    if (system%beam%root%holds_turning) force(2, 0) = 0.0_qp
  end subroutine hold_root

  subroutine keep_mode(search, k, lambda)
    !! Mode k, unless others are so near that they are a cluster.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: k
    type(dd), intent(in) :: lambda
    real(dp) :: correction
    integer :: first, last, n
    call count_at(search, lambda*(1.0_dp - cluster_width), first)
    call count_at(search, lambda*(1.0_dp + cluster_width), last)
    first = min(first + 1, k)
    last = max(last, k)
    if (last > first) then
      call find_cluster(search, first, last, lambda)
      return
    end if
    call count_at(search, lambda, n)
    call improve(search, correction)               ! once more: the motion lags behind the frequency
    call open_cluster(search, k, k, lambda)
    call keep(search, 1)
  end subroutine keep_mode

  pure subroutine open_cluster(search, first, last, lambda)
    !! Room for modes.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: first, last
    type(dd), intent(in) :: lambda
    integer :: n, i
    search%first = first
    search%last = last
    n = size(search%divided(1)%system%piece)
    associate (modes => search%modes)
      modes = piece_modes(system=search%divided(1)%system, lambda=[(lambda, i=first, last)])
      allocate (modes%amplitude(4, n, last - first + 1), modes%deflection(n, last - first + 1), modes%turning(n, last - first + 1))
    end associate
  end subroutine open_cluster

  pure subroutine keep(search, i)
    !! The motion of the last iteration as mode i of the cluster.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: i
    integer :: j
    associate (divided => search%divided(search%parts), modes => search%modes, p => search%parts)
      do j = 1, size(modes%system%piece)
        modes%amplitude(:, j, i) = real(amplitudes_of(divided%stiffness, (j - 1)*p + 1, j*p, &
                                                      extended_ends(modes%system%piece(j), divided%probe%frequency)), dp)
      end do
      modes%deflection(:, i) = real(divided%stiffness%motion(1, p::p), dp)
      modes%turning(:, i) = real(divided%stiffness%motion(2, p::p), dp)
    end associate
  end subroutine keep

  subroutine find_cluster(search, first, last, lambda)
    !! Orthonormal motions of modes at one frequency, from beside it: those before do not excite the next.
    type(extended_search), intent(inout) :: search
    integer, intent(in) :: first, last             !! numbers of the modes
    type(dd), intent(in) :: lambda
    integer, parameter :: rounds = 5
    real(qp), allocatable :: motions(:, :, :), forces(:, :, :)
    real(dp) :: correction
    integer :: i, j, n, round
    call count_at(search, lambda*(1.0_dp + beside), n)
    call open_cluster(search, first, last, lambda)
    associate (motion => search%divided(search%parts)%stiffness%motion)
      allocate (motions(2, size(motion, 2), last - first + 1), forces(2, size(motion, 2), last - first + 1))
      do i = 1, last - first + 1
        call start(search, i)
        do round = 1, rounds
          call hold_root(search%divided(search%parts)%system, search%force)
          do j = 1, i - 1
            search%force = search%force - forces(:, :, j)*(sum(search%force*motions(:, :, j))/sum(forces(:, :, j)*motions(:, :, j)))
          end do
          call improve(search, correction)
        end do
        motions(:, :, i) = motion
        forces(:, :, i) = search%force
        call keep(search, i)
        call orthogonalize(search%modes, i)
      end do
    end associate
  end subroutine find_cluster

  pure subroutine orthogonalize(modes, i)
    !! Take what modes before mode i have from it; mass 1.
    type(piece_modes), intent(inout) :: modes
    integer, intent(in) :: i
    integer, parameter :: rounds = 2
    integer :: j, round
    do round = 1, rounds
      call add(modes, i, 1.0_dp/sqrt(mass_product(modes, i, modes, i)) - 1.0_dp, i)
      do j = 1, i - 1
        call add(modes, i, -mass_product(modes, i, modes, j), j)
      end do
    end do
  end subroutine orthogonalize

  pure subroutine add(modes, i, share, j)
    !! Add a share of mode j to mode i.
    type(piece_modes), intent(inout) :: modes
    integer, intent(in) :: i, j
    real(dp), intent(in) :: share
    modes%amplitude(:, :, i) = modes%amplitude(:, :, i) + share*modes%amplitude(:, :, j)
    modes%deflection(:, i) = modes%deflection(:, i) + share*modes%deflection(:, j)
    modes%turning(:, i) = modes%turning(:, i) + share*modes%turning(:, j)
  end subroutine add

  pure subroutine take(search, k, probe)
    !! Put a probe where mode k is.
    type(extended_search), intent(in) :: search
    integer, intent(in) :: k                       !! of the last cluster
    type(mode_probe), intent(inout) :: probe
    associate (modes => search%modes, i => k - search%first + 1)
      call set_frequency(modes%system, modes%lambda(i), probe)
      probe%amplitude = modes%amplitude(:, :, i)
      probe%motion(1, 1:) = modes%deflection(:, i)
      probe%motion(2, 1:) = modes%turning(:, i)
      call find_drive(modes%system, probe)
      call weigh(modes%system, probe)
    end associate
  end subroutine take

  pure type(dd) function middle(search)
    type(extended_search), intent(in) :: search
    middle = (search%low + search%high)*0.5_dp
  end function middle

  pure real(dp) function gap(a, b)
    !! a − b.
    type(dd), intent(in) :: a, b
    type(dd) :: difference
    difference = a - b
    gap = difference%hi
  end function gap

end module bw_extended_modes

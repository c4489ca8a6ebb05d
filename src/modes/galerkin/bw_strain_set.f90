module bw_strain_set
  !! Modes of a beam of pieces by the coefficients of their strains in each piece: as polynomials are orthonormal,
  !! shapes, overlaps and energies are sums of products. Shapes have ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
  use bw_damping, only: damping_law
  use bw_double_double, only: dd, to_dd, operator(+)
  use bw_kinds, only: dp
  use bw_missing, only: no_number
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: joint_position
  use bw_piece_shape, only: beam_place, place_of
  use bw_piece_strains, only: piece_motions
  use bw_strain_basis, only: basis_values, times_polynomial
  use bw_strain_system, only: stressed, turn_of_piece
  use bw_varying_beam, only: value_of, varying_beam
  implicit none (type, external)
  private

  type, extends(mode_set), public :: strain_set
    type(varying_beam) :: given
    type(piece_motions), allocatable :: piece(:)   !! coefficients of the shapes and of their strains, (pieces)
    real(dp), allocatable :: deflection(:, :)      !! of the joints, (0:pieces, n)
    real(dp), allocatable :: turning(:, :)         !! of the joints, (0:pieces, n)
    real(dp), allocatable :: hub_turn(:)  !! rotation of a free hub, relative to whose line all else is; else unallocated, (n)
    real(dp), allocatable :: rotation(:)           !! β² less the elastic stiffness over the mass, (n)
    integer :: struck_joint = 1                    !! joint at which the mass strikes, or was captured
    real(dp) :: body_inertia = 0.0_dp              !! J of the body captured there
    real(dp) :: body_pull = 0.0_dp                 !! Ω²γ(ξ₀ + R): tension due to its mass, inwards of it
  contains
    procedure :: choose
    procedure :: some_shapes => shapes_of_strains
    procedure :: some_curvatures => curvatures_of_strains
    procedure :: overlap
    procedure, private :: common_overlap
    procedure :: elastic => elastic_of_strains
    procedure :: work
    procedure :: coupling
    procedure :: body_energy => energy_of_body
    procedure :: find_tip_shears
    procedure :: turnings
    procedure :: hub_turns
    procedure :: motion_at
    procedure :: share_of_turn
    procedure :: energy_of_pull
    procedure, private :: in_frame
  end type strain_set

contains

  pure type(strain_set) function choose(self, number) result(chosen)
    !! Return some of these modes, undamped.
    class(strain_set), intent(in) :: self
    integer, intent(in) :: number(:)               !! of the modes, ascending
    integer :: i
    chosen%count = size(number)
    chosen%gamma = self%gamma
    chosen%struck_at = self%struck_at
    chosen%uniform = self%uniform
    chosen%root_power = self%root_power
    chosen%resolved = self%resolved
    chosen%critical_speed = self%critical_speed
    chosen%grows_at_any_speed = self%grows_at_any_speed
    chosen%alpha = self%alpha(number)
    chosen%beta_squared = self%beta_squared(number)
    if (allocated(self%square_rounding)) chosen%square_rounding = self%square_rounding(number)
    chosen%struck = self%struck(number)
    chosen%modal_mass = self%modal_mass(number)
    chosen%phase_velocity = self%phase_velocity(number)
    chosen%group_velocity = self%group_velocity(number)
    chosen%rotation = self%rotation(number)
    if (allocated(self%hub_turn)) chosen%hub_turn = self%hub_turn(number)
    chosen%given = self%given
    chosen%struck_joint = self%struck_joint
    chosen%body_inertia = self%body_inertia
    chosen%body_pull = self%body_pull
    allocate (chosen%piece(size(self%piece)))
    allocate (chosen%deflection(0:size(self%piece), size(number)), source=self%deflection(:, number))
    allocate (chosen%turning(0:size(self%piece), size(number)), source=self%turning(:, number))
    do i = 1, size(self%piece)
      associate (piece => self%piece(i))
        chosen%piece(i) = piece_motions(piece%strain(:, number), piece%turning(:, number), piece%slope(:, number), &
                                        piece%deflection(:, number))
      end associate
    end do
  end function choose

  pure function shapes_of_strains(self, first, last, xi) result(values)
    !! Return the shapes; at joints the joints' deflections.
    class(strain_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    type(beam_place) :: place
    real(dp) :: x
    integer :: p
    do p = 1, size(xi)
      place = place_of(self%given%beam, xi(p))
      x = 0.5_dp + place%offset%hi/self%given%beam%piece(place%piece)%length%hi
      if (x <= 0.0_dp) then
        values(:, p) = self%deflection(place%piece - 1, first:last)
      else if (x >= 1.0_dp) then
        values(:, p) = self%deflection(place%piece, first:last)
      else
        associate (f => self%piece(place%piece)%deflection)
          values(:, p:p) = matmul(transpose(f(:, first:last)), basis_values(size(f, 1), [x]))
        end associate
      end if
      if (xi(p) == self%struck_at .and. .not. allocated(self%hub_turn)) values(:, p) = self%struck(first:last)
    end do
  end function shapes_of_strains

  pure function curvatures_of_strains(self, first, last, xi) result(values)
    !! Return the moment over EI of the root piece; at a joint that of the inner piece. Exactly 0 at a tip without rotational load.
    class(strain_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    type(beam_place) :: place
    real(dp) :: x
    integer :: n, p
    do p = 1, size(xi)
      place = place_of(self%given%beam, xi(p))
      associate (piece => self%given%beam%piece(place%piece), f => self%piece(place%piece))
        x = 0.5_dp + place%offset%hi/piece%length%hi
        n = size(f%turning, 1) - 1
        values(:, p:p) = sqrt(piece%stiffness%hi/piece%length%hi)/self%given%beam%piece(1)%stiffness%hi &
          *matmul(transpose(f%strain(:n, first:last)), basis_values(n, [x]))
        values(:, p:p) = values(:, p:p)*sum(value_of(self%given%law(place%piece)%stiffness, [x]))
      end associate
      associate (tip => self%given%beam%joint(size(self%given%beam%joint)))
        if (xi(p) == 1.0_dp .and. tip%inertia%hi == 0.0_dp .and. tip%turning_stiffness%hi == 0.0_dp) values(:, p) = 0.0_dp
      end associate
    end do
  end function curvatures_of_strains

  pure subroutine find_tip_shears(self, shear, known)
    !! Find shear forces at the tip from the shear strain, if the beam has one.
    class(strain_set), intent(in) :: self
    real(dp), intent(out) :: shear(:)
    logical, intent(out) :: known
    integer :: i, n
    shear = 0.0_dp
    i = size(self%piece)
    associate (piece => self%given%beam%piece(i), f => self%piece(i))
      n = size(f%turning, 1) - 1                 ! curvatures, followed by shear strains
      known = piece%compliance%hi > 0.0_dp
      if (.not. known) return
      shear = sum(value_of(self%given%law(i)%shear, [1.0_dp]))/sqrt(piece%compliance%hi*piece%length%hi) &
        *pack(matmul(transpose(f%strain(n + 1:, :)), basis_values(size(f%strain, 1) - n, [1.0_dp])), .true.)
    end associate
  end subroutine find_tip_shears

  function overlap(self, from, amplitude, with_mass, monitor) result(sums)
    !! Return overlaps with the mass and inertia that both beams have or, with the mass, with that of either beam, but only
    !! common inertia: a captured body arrives without rotation.
    class(strain_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! of the same pieces, springs and joints
    real(dp), intent(in) :: amplitude(:)
    logical, intent(in) :: with_mass
    class(monitor_type), intent(inout), optional :: monitor     ! not asked, as this takes no time
    real(dp) :: sums(self%count)
    real(dp) :: onto(self%count), seen(size(amplitude))
    type(strain_set) :: whole
    integer :: i, n
    select type (from)
    class is (strain_set)
      n = size(amplitude)
      if (allocated(self%hub_turn)) then
        whole = self%in_frame()
        sums = whole%common_overlap(from%in_frame(), amplitude) &
          + self%given%beam%root%hub_inertia%hi*self%hub_turn*sum(from%hub_turn(:n)*amplitude)
      else
        sums = self%common_overlap(from, amplitude)
      end if
      if (.not. with_mass) return
      do i = 1, size(self%piece)
        onto = self%deflection(i, :)
        seen = from%deflection(i, :n)
        if (allocated(self%hub_turn)) then
          onto = onto + (self%given%beam%root%hub_radius%hi + sum(self%given%beam%piece(:i)%length%hi))*self%hub_turn
          seen = seen + (self%given%beam%root%hub_radius%hi + sum(self%given%beam%piece(:i)%length%hi))*from%hub_turn(:n)
        end if
        sums = sums + abs(self%given%beam%joint(i)%mass%hi - from%given%beam%joint(i)%mass%hi)*onto*sum(seen*amplitude)
      end do
      if (present(monitor)) continue
    class default
      sums = no_number()
    end select
  end function overlap

  pure function common_overlap(self, from, amplitude) result(sums)
    !! Return overlaps with the mass and inertia that both beams have, without the hub's.
    class(strain_set), intent(in) :: self
    type(strain_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    integer :: i, n
    n = size(amplitude)
    sums = 0.0_dp
    do i = 1, size(self%piece)
      associate (piece => self%given%beam%piece(i), law => self%given%law(i), &
                 joint => self%given%beam%joint(i), joint_too => from%given%beam%joint(i))
        sums = sums &
          + piece%mass%hi*piece%length%hi*products(law%mass, self%piece(i)%deflection, from%piece(i)%deflection, amplitude) &
          + piece%rotary%hi*piece%length%hi*products(law%rotary, self%piece(i)%turning, from%piece(i)%turning, amplitude) &
          + min(joint%mass%hi, joint_too%mass%hi)*self%deflection(i, :)*sum(from%deflection(i, :n)*amplitude) &
          + min(joint%inertia%hi, joint_too%inertia%hi)*self%turning(i, :)*sum(from%turning(i, :n)*amplitude)
      end associate
    end do
  end function common_overlap

  pure function elastic_of_strains(self) result(squares)
    !! Return λ_k ≥ 0 from strains and springs, or as β² less the terms of rotation if these are smaller: exactly β²
    !! without rotation.
    class(strain_set), intent(in) :: self
    type(dd) :: squares(self%count)
    integer :: k
    squares = [(to_dd(self%work(k, k)/self%modal_mass(k)), k=1, self%count)]
    where (abs(self%rotation) <= squares%hi) squares = self%beta_squared + to_dd(-self%rotation)
    where (squares%hi < 0.0_dp) squares = dd()             ! β² was rounded to 0
  end function elastic_of_strains

  pure real(dp) function work(self, j, k)
    !! Return the work of the elastic forces of mode j in mode k.
    class(strain_set), intent(in) :: self
    integer, intent(in) :: j, k
    integer :: i
    associate (root => self%given%beam%root, v => self%deflection, psi => self%turning)
      work = root%stiffness%hi*v(0, j)*v(0, k) + root%turning_stiffness%hi*psi(0, j)*psi(0, k)
      do i = 1, size(self%piece)
        associate (piece => self%piece(i), law => self%given%law(i), joint => self%given%beam%joint(i))
          work = work &
            + dot_product(piece%strain(:, j), stressed(law%stiffness, law%shear, size(piece%turning, 1) - 1, piece%strain(:, k))) &
            + joint%stiffness%hi*v(i, j)*v(i, k) + joint%turning_stiffness%hi*psi(i, j)*psi(i, k)
        end associate
      end do
    end associate
  end function work

  real(dp) function coupling(self, law) result(ratio)
    !! Return the largest coupling of two modes by damping, |C_ij|/√(C_iiC_jj): how far the damping matrix is from diagonal.
    class(strain_set), intent(in) :: self
    type(damping_law), intent(in) :: law           !! Rayleigh's; one ratio for all modes couples none
    real(dp) :: rate(self%count)
    type(dd) :: elastic(self%count)
    integer :: i, j
    elastic = self%elastic()
    rate = law%rates(elastic%hi)*self%modal_mass
    ratio = 0.0_dp
    do j = 1, self%count
      do i = 1, j - 1
        if (rate(i) > 0.0_dp .and. rate(j) > 0.0_dp) ratio = max(ratio, abs(self%work(i, j))/sqrt(rate(i)*rate(j)))
      end do
    end do
    ratio = ratio*real(law%stiffness, dp)
  end function coupling

  pure function turnings(self) result(turning)
    class(strain_set), intent(in) :: self
    real(dp) :: turning(self%count)
    turning = self%turning(self%struck_joint, :)
    if (allocated(self%hub_turn)) turning = turning + self%hub_turn
  end function turnings

  pure function hub_turns(self) result(turning)
    class(strain_set), intent(in) :: self
    real(dp) :: turning(self%count)
    turning = 0.0_dp
    if (allocated(self%hub_turn)) turning = self%hub_turn
  end function hub_turns

  pure type(strain_set) function in_frame(self) result(whole)
    !! Return the motions in the uniformly rotating frame: those relative to the line of a free hub, and its rotation.
    class(strain_set), intent(in) :: self
    real(dp) :: arm
    integer :: i, n
    whole%count = self%count
    whole%given = self%given
    whole%piece = self%piece
    allocate (whole%deflection(0:size(self%piece), self%count), source=self%deflection)
    allocate (whole%turning(0:size(self%piece), self%count), source=self%turning)
    if (.not. allocated(self%hub_turn)) return
    arm = self%given%beam%root%hub_radius%hi
    whole%deflection(0, :) = whole%deflection(0, :) + arm*self%hub_turn
    do i = 1, size(self%piece)
      n = size(self%piece(i)%deflection, 1)
      arm = arm + self%given%beam%piece(i)%length%hi
      whole%deflection(i, :) = whole%deflection(i, :) + arm*self%hub_turn
      whole%piece(i)%deflection = whole%piece(i)%deflection &
        + spread(turn_of_piece(self%given, i, n), 2, self%count)*spread(self%hub_turn, 1, n)
      whole%piece(i)%turning(1, :) = whole%piece(i)%turning(1, :) + self%hub_turn
      whole%piece(i)%slope(1, :) = whole%piece(i)%slope(1, :) + self%hub_turn
    end do
    whole%turning = whole%turning + spread(self%hub_turn, 1, size(whole%turning, 1))
  end function in_frame

  pure function motion_at(self, xi) result(motion)
    class(strain_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp) :: motion(self%count, 2)
    type(beam_place) :: place
    real(dp) :: arm, x
    place = place_of(self%given%beam, xi)
    associate (i => place%piece)
      x = 0.5_dp + place%offset%hi/self%given%beam%piece(i)%length%hi
      arm = self%given%beam%root%hub_radius%hi + sum(self%given%beam%piece(:i - 1)%length%hi) &
        + x*self%given%beam%piece(i)%length%hi
      if (x <= 0.0_dp) then
        motion(:, 1) = self%deflection(i - 1, :)
        motion(:, 2) = self%turning(i - 1, :)
      else if (x >= 1.0_dp) then
        motion(:, 1) = self%deflection(i, :)
        motion(:, 2) = self%turning(i, :)
      else
        associate (v => self%piece(i)%deflection, psi => self%piece(i)%turning)
          motion(:, 1:1) = matmul(transpose(v), basis_values(size(v, 1), [x]))
          motion(:, 2:2) = matmul(transpose(psi), basis_values(size(psi, 1), [x]))
        end associate
      end if
    end associate
    if (allocated(self%hub_turn)) motion = motion + spread([arm, 1.0_dp], 1, self%count)*spread(self%hub_turn, 2, 2)
  end function motion_at

  pure function share_of_turn(self) result(share)
    class(strain_set), intent(in) :: self
    real(dp) :: share(self%count)
    type(strain_set) :: whole
    real(dp) :: arm
    integer :: i
    whole = self%in_frame()
    share = 0.0_dp
    arm = self%given%beam%root%hub_radius%hi
    do i = 1, size(self%piece)
      associate (piece => self%given%beam%piece(i), law => self%given%law(i), joint => self%given%beam%joint(i), &
                 v => whole%piece(i)%deflection, psi => whole%piece(i)%turning)
        arm = arm + piece%length%hi
        share = share + piece%mass%hi*piece%length%hi &
          *products(law%mass, v, spread(turn_of_piece(self%given, i, size(v, 1)), 2, 1), [1.0_dp]) &
          + piece%rotary%hi*piece%length%hi &
          *products(law%rotary, psi, reshape([1.0_dp, spread(0.0_dp, 1, size(psi, 1) - 1)], [size(psi, 1), 1]), [1.0_dp]) &
          + joint%mass%hi*arm*whole%deflection(i, :) + joint%inertia%hi*whole%turning(i, :)
      end associate
    end do
    if (allocated(self%hub_turn)) share = share + self%given%beam%root%hub_inertia%hi*self%hub_turn
  end function share_of_turn

  pure function energy_of_body(self, q, rate) result(energy)
    !! Return ½Jψ̇² of the captured body, and ½T_b∫v'² over the beam inwards of it, the work against its centrifugal
    !! force. Rotation does no work on its ψ: in plane (ω + ψ̇)² leaves none, out of plane the body is isotropic.
    class(strain_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)          !! (modes)
    real(dp) :: energy(2)
    energy(1) = 0.0_dp
    if (self%body_inertia > 0.0_dp) energy(1) = 0.5_dp*self%body_inertia*sum(turned(self%turnings(), rate))**2
    energy(2) = self%body_pull*shortening(self, self%struck_joint, q)
  end function energy_of_body

  pure real(dp) function energy_of_pull(self, xi, q) result(energy)
    class(strain_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp), intent(in) :: q(:)
    real(dp), parameter :: same_place = 1.0e-14_dp
    type(dd) :: joint
    integer :: i
    energy = 0.0_dp
    if (.not. self%given%is_pulled) return
    do i = 1, size(self%piece)
      joint = joint_position(self%given%beam, i)
      if (joint%hi > xi - same_place) exit
    end do
    energy = shortening(self, min(i, size(self%piece)), q)
  end function energy_of_pull

  pure real(dp) function shortening(self, joint, q) result(way)
    !! Return ½∫v'² up to a joint, with the rotation of a free hub.
    class(strain_set), intent(in) :: self
    integer, intent(in) :: joint
    real(dp), intent(in) :: q(:)                   !! of the first modes
    real(dp) :: first, turn
    integer :: i
    way = 0.0_dp
    turn = 0.0_dp
    if (allocated(self%hub_turn)) turn = dot_product(self%hub_turn(:size(q)), q)
    do i = 1, joint
      first = dot_product(self%piece(i)%slope(1, :size(q)), q)
      way = way + 0.5_dp*self%given%beam%piece(i)%length%hi &
        *(sum(matmul(self%piece(i)%slope(:, :size(q)), q)**2) + turn*(2.0_dp*first + turn))
    end do
    way = way + turn*(dot_product(self%deflection(0, :size(q)), q) + 0.5_dp*self%given%beam%root%hub_radius%hi*turn)
  end function shortening

  pure function turned(turning, rate) result(parts)
    real(dp), intent(in) :: turning(:), rate(:)            !! of all modes; of the first ones
    real(dp) :: parts(size(rate))
    parts = turning(:size(rate))*rate
  end function turned

  pure function products(weight, onto, from, amplitude) result(sums)
    !! Return Σ_i a_i∫w o_k f_i over the polynomials of both sets, (modes of `onto`).
    real(dp), intent(in) :: weight(:)                      !! coefficients of w
    real(dp), intent(in) :: onto(:, :), from(:, :)         !! coefficients, (functions, modes)
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(size(onto, 2))
    integer :: n
    n = min(size(onto, 1), size(from, 1))
    sums = matmul(times_polynomial(weight, matmul(from(:n, :size(amplitude)), amplitude)), onto(:n, :))
  end function products

end module bw_strain_set

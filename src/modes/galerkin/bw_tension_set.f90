module bw_tension_set
  !! Modes of a beam of pieces with tension, known by the coefficients of their strains in each piece.
  use bw_double_double, only: dd, to_dd, operator(+)
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: piece_beam
  use bw_piece_shape, only: beam_place, place_of
  use bw_piece_strains, only: piece_motions
  use bw_strain_basis, only: basis_values
  use bw_strain_set, only: products, strain_set
  implicit none (type, external)
  private

  type, extends(strain_set), public :: tension_set
    type(piece_beam) :: beam
    type(piece_motions), allocatable :: piece(:)   !! coefficients of the shapes and of their strains, (pieces)
    real(dp), allocatable :: deflection(:, :)      !! of the joints, (0:pieces, n)
    real(dp), allocatable :: turning(:, :)         !! of the joints, (0:pieces, n)
    integer :: struck_joint = 1                    !! where the mass strikes, or has been captured
    real(dp) :: body_inertia = 0.0_dp              !! J of the body that has been captured there
    real(dp) :: body_pull = 0.0_dp                 !! Ω²γ(ξ₀ + R): tension that its mass brings into the beam inside of it
  contains
    procedure :: choose => choose_modes
    procedure :: some_shapes => tension_shapes
    procedure :: some_curvatures => tension_curvatures
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: elastic => elastic_of_strains
    procedure :: works => works_of_strains
    procedure :: body_energy => energy_of_body
  end type tension_set

contains

  subroutine choose_modes(self, number, chosen)
    class(tension_set), intent(in) :: self
    integer, intent(in) :: number(:)
    class(strain_set), allocatable, intent(out) :: chosen
    type(tension_set), allocatable :: found
    integer :: i
    allocate (found)
    call found%take_numbers(self, number)
    found%beam = self%beam
    found%struck_joint = self%struck_joint
    found%body_inertia = self%body_inertia
    found%body_pull = self%body_pull
    allocate (found%piece(size(self%piece)))
    allocate (found%deflection(0:size(self%piece), size(number)), source=self%deflection(:, number))
    allocate (found%turning(0:size(self%piece), size(number)), source=self%turning(:, number))
    do i = 1, size(self%piece)
      associate (piece => self%piece(i))
        found%piece(i) = piece_motions(piece%strain(:, number), piece%turning(:, number), piece%slope(:, number), &
                                       piece%deflection(:, number))
      end associate
    end do
    call move_alloc(found, chosen)
  end subroutine choose_modes

  pure function tension_shapes(self, first, last, xi) result(values)
    !! At joints their own deflections.
    class(tension_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    type(beam_place) :: place
    real(dp) :: x
    integer :: p
    do p = 1, size(xi)
      place = place_of(self%beam, xi(p))
      x = 0.5_dp + place%offset%hi/self%beam%piece(place%piece)%length%hi
      if (x <= 0.0_dp) then
        values(:, p) = self%deflection(place%piece - 1, first:last)
      else if (x >= 1.0_dp) then
        values(:, p) = self%deflection(place%piece, first:last)
      else
        associate (f => self%piece(place%piece)%deflection)
          values(:, p:p) = matmul(transpose(f(:, first:last)), basis_values(size(f, 1), [x]))
        end associate
      end if
      if (xi(p) == self%struck_at) values(:, p) = self%struck(first:last)
    end do
  end function tension_shapes

  pure function tension_curvatures(self, first, last, xi) result(values)
    !! The moment over EI of the root piece; at a joint that of the piece inside it. Exactly 0 at a tip where nothing turns it.
    class(tension_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    type(beam_place) :: place
    real(dp) :: x
    integer :: n, p
    do p = 1, size(xi)
      place = place_of(self%beam, xi(p))
      associate (piece => self%beam%piece(place%piece), f => self%piece(place%piece))
        x = 0.5_dp + place%offset%hi/piece%length%hi
        n = size(f%turning, 1) - 1
        values(:, p:p) = sqrt(piece%stiffness%hi/piece%length%hi)/self%beam%piece(1)%stiffness%hi &
          *matmul(transpose(f%strain(:n, first:last)), basis_values(n, [x]))
      end associate
      associate (tip => self%beam%joint(size(self%beam%joint)))
        if (xi(p) == 1.0_dp .and. tip%inertia%hi == 0.0_dp .and. tip%turning_stiffness%hi == 0.0_dp) values(:, p) = 0.0_dp
      end associate
    end do
  end function tension_curvatures

  function overlap_of_beam(self, from, amplitude, monitor) result(sums)
    !! With all mass and inertia that both beams have.
    class(tension_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! of the same pieces, springs and joints
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor     ! not asked: it takes no time
    real(dp) :: sums(self%count)
    integer :: i, n
    select type (from)
    class is (tension_set)
      n = size(amplitude)
      sums = 0.0_dp
      do i = 1, size(self%piece)
        associate (piece => self%beam%piece(i), joint => self%beam%joint(i), joint_too => from%beam%joint(i))
          sums = sums + piece%mass%hi*piece%length%hi*products(self%piece(i)%deflection, from%piece(i)%deflection, amplitude) &
            + piece%rotary%hi*piece%length%hi*products(self%piece(i)%turning, from%piece(i)%turning, amplitude) &
            + min(joint%mass%hi, joint_too%mass%hi)*self%deflection(i, :)*sum(from%deflection(i, :n)*amplitude) &
            + min(joint%inertia%hi, joint_too%inertia%hi)*self%turning(i, :)*sum(from%turning(i, :n)*amplitude)
        end associate
      end do
      if (present(monitor)) continue
    class default
      error stop 'bw_tension_set: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  function overlap_with_mass(self, from, amplitude, monitor) result(sums)
    !! With the masses of either beam, but no inertia of a body that only one of them has: it arrives without spin.
    class(tension_set), intent(in) :: self
    class(mode_set), intent(in) :: from            !! as that of `overlap_of_beam`
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    integer :: i
    sums = self%overlap_of_beam(from, amplitude, monitor)
    select type (from)
    class is (tension_set)
      do i = 1, size(self%piece)
        sums = sums + abs(self%beam%joint(i)%mass%hi - from%beam%joint(i)%mass%hi) &
          *self%deflection(i, :)*sum(from%deflection(i, :size(amplitude))*amplitude)
      end do
    end select
  end function overlap_with_mass

  pure function elastic_of_strains(self) result(squares)
    !! λ_k ≥ 0 from strains and springs, or from β² less what rotation adds where that is the smaller part.
    class(tension_set), intent(in) :: self
    type(dd) :: squares(self%count)
    integer :: k
    squares = [(to_dd(work_of(self, k, k)/self%modal_mass(k)), k=1, self%count)]
    where (abs(self%rotation) <= squares%hi) squares = self%beta_squared + to_dd(-self%rotation)
    where (squares%hi < 0.0_dp) squares = dd()             ! β² has been rounded to 0
  end function elastic_of_strains

  pure real(dp) function work_of(self, j, k) result(work)
    !! Of the elastic forces of mode j in mode k.
    class(tension_set), intent(in) :: self
    integer, intent(in) :: j, k
    integer :: i
    associate (root => self%beam%root, v => self%deflection, psi => self%turning)
      work = root%stiffness%hi*v(0, j)*v(0, k) + root%turning_stiffness%hi*psi(0, j)*psi(0, k)
      do i = 1, size(self%piece)
        work = work + dot_product(self%piece(i)%strain(:, j), self%piece(i)%strain(:, k)) &
          + self%beam%joint(i)%stiffness%hi*v(i, j)*v(i, k) + self%beam%joint(i)%turning_stiffness%hi*psi(i, j)*psi(i, k)
      end do
    end associate
  end function work_of

  pure function works_of_strains(self) result(works)
    class(tension_set), intent(in) :: self
    real(dp) :: works(self%count, self%count)
    integer :: i, j
    do j = 1, self%count
      works(:, j) = [(work_of(self, i, j)/sqrt(self%modal_mass(i)*self%modal_mass(j)), i=1, self%count)]
    end do
  end function works_of_strains

  pure function energy_of_body(self, q, rate) result(energy)
    !! ½Jψ̇² of the captured body, and ½T_b∫v'² over the beam inside of it: how far its centrifugal force has been drawn inwards.
    !! Rotation does no work on its turning: in plane (ω + ψ̇)² leaves none, and out of plane the body is isotropic.
    class(tension_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)          !! (modes)
    real(dp) :: energy(2)
    integer :: i
    energy(1) = 0.5_dp*self%body_inertia*dot_product(self%turning(self%struck_joint, :size(rate)), rate)**2
    energy(2) = 0.0_dp
    do i = 1, self%struck_joint
      energy(2) = energy(2) + 0.5_dp*self%body_pull*self%beam%piece(i)%length%hi &
        *sum(matmul(self%piece(i)%slope(:, :size(q)), q)**2)
    end do
  end function energy_of_body

end module bw_tension_set

module bw_joint_unknowns
  !! The unknowns for the motion of a beam's joints: v and ψ of each joint, except that the joints of a short or thick
  !! piece, far stiffer than the beam, are linked.
  !!
  !! In terms of v and ψ at both ends such a piece has stiffnesses of 12B/L³, however soft its material, and motions that hardly
  !! bend it would lose digits: the error of β² of the first mode would be some L⁻³/B roundings. So linked joints follow the one
  !! that is hardest to move, and each such piece has two unknowns of its own, e = Δψ and d = Δv/L − ½(ψ + ψ'): the follower has
  !! ψ' = ψ + e and v' = v + L(ψ + ½e + d). A body or a spring is then in one column unless something near is harder to move.
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: unknowns_of_joints

  real(dp), parameter :: stiff = 3e-3_dp           !! L³/B of a stiff piece over the flexibility of the beam at its tip

  type, public :: joint_unknowns
    !! Motions of joints and pieces for each unknown of size 1, (unknowns, joints from 0 to n) or (unknowns, pieces).
    integer :: number = 0
    real(dp), allocatable :: deflection(:, :)      !! v of the joints
    real(dp), allocatable :: turning(:, :)         !! ψ of the joints
    real(dp), allocatable :: bend(:, :)            !! Δψ over the pieces
    real(dp), allocatable :: shift(:, :)           !! Δv/L − ½(ψ + ψ')
  end type joint_unknowns

contains

  pure type(joint_unknowns) function unknowns_of_joints(beam) result(unknowns)
    !! Order the unknowns: those of stiff pieces first, then joints from the lightest to the heaviest, which keeps digits.
    type(piece_beam), intent(in) :: beam
    real(dp) :: weight(0:size(beam%piece))
    logical :: tied(size(beam%piece)), leads(0:size(beam%piece))
    integer :: i, j, n
    n = size(beam%piece)
    weight = [0.0_dp, max(beam%joint%mass%hi, beam%joint%inertia%hi)]
    tied = is_tied(beam)
    leads = [(leader_of(beam, tied, holds(beam), j) == j, j=0, n)]
    allocate (unknowns%deflection(2*n + 2, 0:n), unknowns%turning(2*n + 2, 0:n), source=0.0_dp)
    allocate (unknowns%bend(2*n + 2, n), unknowns%shift(2*n + 2, n), source=0.0_dp)
    do i = 1, n
      if (tied(i)) call add(unknowns%bend(:, i))
      if (tied(i)) call add(unknowns%shift(:, i))
    end do
    do i = 0, n
      j = minloc(weight, 1) - 1
      weight(j) = huge(weight)
      if (leads(j)) call place(j)
    end do
    call find_others(beam%piece%length%hi, tied, leads, unknowns)
  contains
    pure subroutine place(j)
      !! Put v and ψ in this order, unless mass exceeds inertia.
      integer, intent(in) :: j
      logical :: heavy_mass
      heavy_mass = .false.
      if (j > 0) heavy_mass = beam%joint(j)%mass%hi > 3.0_dp*beam%joint(j)%inertia%hi
      if (.not. heavy_mass .and. .not. (j == 0 .and. beam%root%holds_deflection)) call add(unknowns%deflection(:, j))
      if (.not. (j == 0 .and. beam%root%holds_turning)) call add(unknowns%turning(:, j))
      if (heavy_mass) call add(unknowns%deflection(:, j))
    end subroutine place
    pure subroutine add(motion)
      real(dp), intent(inout) :: motion(:)
      unknowns%number = unknowns%number + 1
      motion(unknowns%number) = 1.0_dp
    end subroutine add
  end function unknowns_of_joints

  pure function is_tied(beam) result(tied)
    !! Return which pieces are stiff and link their ends. The first piece of a clamped root is not linked.
    type(piece_beam), intent(in) :: beam
    logical :: tied(size(beam%piece))
    real(dp) :: flexibility(size(beam%piece))      ! of the tip, due to bending of each piece
    real(dp) :: beyond                             ! from a piece to the tip
    integer :: i
    beyond = 0.0_dp
    do i = size(tied), 1, -1
      associate (length => beam%piece(i)%length%hi)
        flexibility(i) = length*(beyond*(beyond + length) + length**2/3.0_dp)/beam%piece(i)%stiffness%hi
        beyond = beyond + length
      end associate
    end do
    tied = beam%piece%length%hi**3/beam%piece%stiffness%hi < stiff*sum(flexibility)
    if (beam%root%holds_deflection .and. beam%root%holds_turning) tied(1) = .false.
  end function is_tied

  pure function holds(beam) result(hold)
    !! Return how hard each joint is to move: inertia, springs, and the first piece next to a clamped root.
    type(piece_beam), intent(in) :: beam
    real(dp) :: hold(0:size(beam%piece))
    hold(0) = 0.0_dp
    associate (joint => beam%joint, first => beam%piece(1))
      hold(1:) = max(joint%mass%hi, joint%inertia%hi, joint%stiffness%hi, joint%turning_stiffness%hi)
      if (beam%root%holds_deflection .and. beam%root%holds_turning) hold(1) = max(hold(1), first%stiffness%hi/first%length%hi**3)
    end associate
  end function holds

  pure integer function leader_of(beam, tied, hold, j) result(leader)
    !! Return the joint that joint j follows, or j itself. A supported root follows no other joint.
    type(piece_beam), intent(in) :: beam
    logical, intent(in) :: tied(:)
    real(dp), intent(in) :: hold(0:)
    integer, intent(in) :: j
    integer :: first, last
    first = findloc([.false., tied(:j)], .false., dim=1, back=.true.) - 1
    last = findloc([tied(j + 1:), .false.], .false., dim=1) + j - 1
    leader = maxloc(hold(first:last), 1) + first - 1
    if (first == 0 .and. (beam%root%holds_deflection .or. beam%root%holds_turning)) leader = 0
  end function leader_of

  pure subroutine find_others(length, tied, leads, unknowns)
    !! Find the motions of following joints, and of the ends of pieces without links.
    real(dp), intent(in) :: length(:)
    logical, intent(in) :: tied(:), leads(0:)
    type(joint_unknowns), intent(inout) :: unknowns
    integer :: i, j
    associate (v => unknowns%deflection, psi => unknowns%turning, e => unknowns%bend, d => unknowns%shift)
      do j = 0, size(tied)
        if (.not. leads(j)) cycle
        do i = j + 1, size(tied)
          if (.not. tied(i)) exit
          psi(:, i) = psi(:, i - 1) + e(:, i)
          v(:, i) = v(:, i - 1) + length(i)*(psi(:, i - 1) + 0.5_dp*e(:, i) + d(:, i))
        end do
        do i = j, 1, -1
          if (.not. tied(i)) exit
          psi(:, i - 1) = psi(:, i) - e(:, i)
          v(:, i - 1) = v(:, i) - length(i)*(psi(:, i) - 0.5_dp*e(:, i) + d(:, i))
        end do
      end do
      do i = 1, size(tied)
        if (tied(i)) cycle
        e(:, i) = psi(:, i) - psi(:, i - 1)
        d(:, i) = (v(:, i) - v(:, i - 1))/length(i) - 0.5_dp*(psi(:, i) + psi(:, i - 1))
      end do
    end associate
  end subroutine find_others

end module bw_joint_unknowns
